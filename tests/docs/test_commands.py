"""Commands in the documents are commands that there are."""

import re
import shlex
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import yaml

from command_line import with_subcommands
from document import ROOT, blocks, commands, files
from ml2_receiver.cli import command_line
from ml2_receiver.generated.version import VERSION
from ml2_receiver.table.reader import load_table

URI = f"ml2s://127.0.0.1:7755?fp={'0' * 64}&token={'0' * 32}"


def documented(program: str) -> Iterator[tuple[Path, list[str]]]:
    """A program's arguments, wherever it is shown."""
    for document in files("*.md"):
        for line in commands(document.read_text()):
            if re.match(rf"(?:\S+/)?{program} ", line) and not line.endswith(" ..."):
                yield document, shlex.split(line.replace("ml2s://...", URI), comments=True)[1:]


def shown_in_help() -> Iterator[tuple[str, list[str]]]:
    """The examples of every --help: a command, two spaces, and what it is for."""
    for words, parser in with_subcommands(("ml2-receiver",), command_line()):
        for line in re.sub(r"\\\n *", "", parser.epilog or "").splitlines():
            if example := re.match(r"  ml2-receiver (.+?)(?: {2}.*| \| .*)?$", line):
                arguments = shlex.split(example[1].replace("ml2s://...", URI))
                yield " ".join((*words, "--help")), arguments


def test_the_receivers_commands_are_parsed_as_they_are_shown() -> None:
    documents = [(str(file.relative_to(ROOT)), it) for file, it in documented("ml2-receiver")]
    helps = list(shown_in_help())
    assert len(documents) > 30
    assert len(helps) > 40
    parser = command_line()
    wrong = []
    for place, arguments in documents + helps:
        said = StringIO()
        try:
            with redirect_stdout(said), redirect_stderr(said):
                parser.parse_args(arguments)
        except SystemExit as end:
            if end.code:
                wrong.append(f"{place}: {arguments}: {said.getvalue()}")
    assert not wrong, "\n".join(wrong)


def test_the_targets_of_make_exist() -> None:
    makefile = (ROOT / "Makefile").read_text()
    known = set(re.findall(r"^([a-z][a-z0-9-]*):", makefile, re.MULTILINE))
    shown = {
        name
        for document in files("*.md")
        for name in re.findall(r"(?:`|^)make ([a-z][a-z0-9-]*)", document.read_text(), re.M)
    }
    assert len(shown) > 10
    assert shown <= known


def test_the_keys_of_an_excerpt_of_the_configuration_exist() -> None:
    sections = load_table().sections.values()
    documents = [
        ROOT / it for it in ("host_receiver/README.md", "docs/calibration.md", "docs/slam.md")
    ]
    excerpts = [
        yaml.safe_load(it) for document in documents for it in blocks(document.read_text(), "yaml")
    ]
    assert len(excerpts) == 3
    sectioned = [it.get("/ml2_receiver", {"ros__parameters": it}) for it in excerpts]
    keys = {
        (section, key)
        for it in sectioned
        for section, values in it["ros__parameters"].items()
        for key in values
    }
    assert keys
    assert keys <= {(section.id, key) for section in sections for key in section.keys}


def test_the_readme_names_this_version_and_one_place_to_replace() -> None:
    readme = (ROOT / "README.md").read_text()
    assert set(re.findall(r"\b\d+\.\d+\.\d+\b", readme)) == {VERSION}
    shown = "\n".join(line for file in files("*.md") for line in commands(file.read_text()))
    assert shown.count("REPOSITORY") == 1
    assert "example.com" not in shown


def test_the_gradle_files_of_a_new_app_name_our_versions() -> None:
    page = (ROOT / "ml2-sensors-aar/README.md").read_text()
    ours = dict(re.findall(r"<(kotlin|r8)\.version>(.*)</", (ROOT / "pom.xml").read_text()))
    assert re.findall(r'"dev.ml2sensors:ml2-sensors:(.*)"', page) == [VERSION]
    assert re.findall(r'"com.android.tools:r8:(.*)"', page) == [ours["r8"]]
    assert re.findall(r'^kotlin = "(.*)"', page, re.MULTILINE) == [ours["kotlin"]]

"""Files for a public host of the repository, by the schemas of what reads them there."""

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
WORKFLOWS = sorted((ROOT / ".github/workflows").glob("*.yml"))
TEMPLATES = ROOT / ".github/ISSUE_TEMPLATE"
FORMS = [file for file in sorted(TEMPLATES.glob("*.yml")) if file.name != "config.yml"]
HOOKS = ROOT / ".pre-commit-config.yaml"
# The newest major version of each action when it was chosen.
ACTIONS = {"actions/cache@v5", "actions/checkout@v6", "actions/upload-artifact@v7"}


@pytest.mark.parametrize(
    ("schema", "files"),
    [
        ("github-workflows", WORKFLOWS),
        ("github-issue-forms", FORMS),
        ("github-issue-config", [TEMPLATES / "config.yml"]),
    ],
)
def test_a_file_is_valid_by_its_schema(schema: str, files: list[Path]) -> None:
    check = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}"]
    command = [*check, *map(str, files)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert files
    assert done.returncode == 0, done.stdout


def test_pre_commit_reads_its_hooks() -> None:
    command = [sys.executable, "-m", "pre_commit", "validate-config", str(HOOKS)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_what_hooks_and_workflows_run_is_in_the_repository() -> None:
    tracked = ["git", "ls-files", "-co", "--exclude-standard"]
    known = set(
        subprocess.run(tracked, cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    )
    lines = [line for step in steps() for line in step.get("run", "").splitlines()]
    lines += [hook["entry"] for hook in hooks()]
    targets = set(re.findall(r"^([a-z][a-z0-9-]*):", (ROOT / "Makefile").read_text(), re.M))
    called = [re.search(r"\bmake ([a-z-]+)", line) for line in lines]
    assert {match[1] for match in called if match} == {"dist", "format"} <= targets
    files = {word for line in lines for word in line.split() if re.match(r"\.?[\w-]+/", word)}
    files -= {"build/dist/*", "build/dist/dev.ml2sensors.unity-*.tgz"}
    assert {".ci/run", "host_receiver/environment/run.sh"} <= files <= known
    programs = {entry for hook in hooks() if "/" not in (entry := hook["entry"].split()[0])}
    assert all(shutil.which(name) for name in programs)


def test_workflows_use_known_actions_on_the_supported_system() -> None:
    assert {step["uses"] for step in steps() if "uses" in step} == ACTIONS
    assert {job["runs-on"] for job in jobs()} == {"ubuntu-24.04"}
    assert all(job["timeout-minutes"] for job in jobs())


def test_a_bug_report_asks_for_the_bundle_of_doctor() -> None:
    form = yaml.safe_load((TEMPLATES / "bug_report.yml").read_text())
    asked = {part["id"]: part for part in form["body"] if part["type"] != "markdown"}
    assert "ml2-receiver doctor --bundle" in asked["bundle"]["attributes"]["description"]
    assert asked["bundle"]["validations"]["required"]


def jobs() -> Iterator[dict[str, Any]]:
    for file in WORKFLOWS:
        yield from yaml.safe_load(file.read_text())["jobs"].values()


def steps() -> Iterator[dict[str, Any]]:
    for job in jobs():
        yield from job["steps"]


def hooks() -> Iterator[dict[str, Any]]:
    for repository in yaml.safe_load(HOOKS.read_text())["repos"]:
        yield from repository["hooks"]

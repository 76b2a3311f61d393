"""Every link of every document leads somewhere; places and lines of code that it shows exist."""

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import pytest

from document import ROOT, blocks, files, without_spacing

_LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^()\s]+)\)")
# `folder/file.py:name`, the way documents name a place in the code.
_PLACE = re.compile(r"`([\w/.-]+\.(?:c|cs|h|kt|py|xml|yaml)):([^`\d][^`]*)`")
# A block of code that names the file from which its lines are.
_QUOTE = re.compile(r"^```\w+ (\S+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_CODE = re.compile(r"^```.*?^```$|`[^`\n]+`", re.DOTALL | re.MULTILINE)


def links() -> Iterator[tuple[Path, str]]:
    for document in files("*.md"):
        for target in _LINK.findall(_CODE.sub("", document.read_text())):
            if ":" not in target:
                yield document, target


def anchors(document: Path) -> set[str]:
    """Returns the anchors of a document's headings, as GitHub and GitLab make them."""
    headings = re.findall(r"^#+ (.*)$", document.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", it.lower()).replace(" ", "-") for it in headings}


def is_broken(document: Path, target: str) -> bool:
    name, _, anchor = unquote(target).partition("#")
    file = document.parent / name if name else document
    return not file.exists() or (bool(anchor) and anchor not in anchors(file))


def test_every_link_leads_to_a_file_and_a_heading_that_exist() -> None:
    found = list(links())
    assert len(found) > 50
    broken = [f"{it.relative_to(ROOT)}: {target}" for it, target in found if is_broken(it, target)]
    assert not broken, "\n".join(broken)


def test_every_place_in_the_code_exists() -> None:
    sources = {f"/{file.relative_to(ROOT)}": file for file in files()}
    missing = []
    for document in files("*.md"):
        for name, words in _PLACE.findall(document.read_text()):
            found = [it for path, it in sources.items() if path.endswith(f"/{name}")]
            if not any(words in it.read_text() for it in found):
                missing.append(f"{document.relative_to(ROOT)}: `{name}:{words}`")
    assert not missing, "\n".join(missing)


# A definition of a name, by the suffix of the file's language.
_DEFINITIONS = {
    ".kt": r"\b(fun|val|var|class|object|interface)\s+(<[^>]*>\s*)?([\w<>?]+\.)?NAME\b",
    ".py": r"^\s*(async def|def|class)\s+NAME\b",
    ".c": r"^\w[\w\s*]*\bNAME\(",
    ".h": r"^\w[\w\s*]*\bNAME\(",
}


# Comments, strings that stand alone, and names that a file only imports, which call nothing.
_NO_CODE = re.compile(
    r'^\s*(?://|#|/?\*|import\b|from\b).*$|\s//.*$|\s+# .*$|(?s:""".*?""")', re.MULTILINE
)
_TESTS = re.compile(r"(^|/)(tests?|android-test|Tests)(/|$)")


def walked() -> list[tuple[str, str]]:
    """The file and the function of each step of the walkthroughs."""
    places: list[tuple[str, str]] = _PLACE.findall((ROOT / "docs/walkthroughs.md").read_text())
    assert len(places) > 50
    return places


def definition(file: str, name: str) -> re.Pattern[str]:
    pattern = _DEFINITIONS[Path(file).suffix].replace("NAME", re.escape(name))
    return re.compile(pattern, re.MULTILINE)


def test_every_function_of_a_walkthrough_is_defined_where_it_says() -> None:
    sources = {f"/{file.relative_to(ROOT)}": file for file in files()}
    missing = []
    for file, name in walked():
        found = [it for path, it in sources.items() if path.endswith(f"/{file}")]
        if not any(definition(file, name).search(it.read_text()) for it in found):
            missing.append(f"`{file}:{name}`")
    assert not missing, "\n".join(missing)


def test_every_function_of_a_walkthrough_is_called_by_what_ships() -> None:
    """An override is called by what declares it, such as Android."""
    code = [
        (file.suffix, _NO_CODE.sub("", file.read_text()))
        for file in files()
        if file.suffix in _DEFINITIONS and not _TESTS.search(str(file.relative_to(ROOT)))
    ]
    unused = []
    for file, name in walked():
        suffixes = (".c", ".h") if file.endswith((".c", ".h")) else (Path(file).suffix,)
        of_language = [text for suffix, text in code if suffix in suffixes]
        uses = sum(len(re.findall(rf"\b{re.escape(name)}\b", text)) for text in of_language)
        uses -= sum(len(definition(file, name).findall(text)) for text in of_language)
        is_override = any(f"override fun {name}(" in text for text in of_language)
        if not uses and not is_override:
            unused.append(f"`{file}:{name}`")
    assert not unused, "\n".join(unused)


def test_lines_that_a_document_shows_of_a_file_are_in_it() -> None:
    quotes = [it for document in files("*.md") for it in _QUOTE.findall(document.read_text())]
    assert quotes
    for name, code in quotes:
        lines = (ROOT / name).read_text().splitlines()
        assert [line for line in code.splitlines() if line not in lines] == [], name


# `tests/aar` compiles the Kotlin, `tests/unity/run.sh` the C#. The receiver runs the Python.
_COMPILED = {
    "kotlin": "ml2-sensors-aar/sample/src/main/kotlin/dev/ml2sensors/sample/ReadmeExamples.kt",
    "csharp": "unity_package/Tests/Mono~/DocumentedExamples.cs",
}


@pytest.mark.parametrize("language", _COMPILED)
def test_each_line_of_an_example_in_the_readme_is_compiled(language: str) -> None:
    compiled = {
        without_spacing(line) for line in (ROOT / _COMPILED[language]).read_text().splitlines()
    }
    (example,) = blocks((ROOT / "README.md").read_text(), language)
    lines = example.splitlines()
    assert lines
    assert [line for line in lines if without_spacing(line) not in compiled] == []


def test_who_helps_with_a_headset_begins_with_the_first_assumptions() -> None:
    asked = re.findall(r"^- \[ \] \*\*(.+?)\*\*", (ROOT / "README.md").read_text(), re.MULTILINE)
    page = (ROOT / "docs/unconfirmed.md").read_text()
    rows = re.findall(r"^\| (.+?) \|", page, re.MULTILINE)
    assert len(asked) == 4
    assert rows[1:5] == asked  # the first is the head of the table

"""Every link of every document leads somewhere."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from document import ROOT, files

_LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(([^()\s]+)\)")
_CODE = re.compile(r"^```.*?^```$|^ {4}.*?$|`[^`\n]+`", re.DOTALL | re.MULTILINE)


def links() -> Iterator[tuple[Path, str]]:
    for document in files("*.md"):
        for target in _LINK.findall(_CODE.sub("", document.read_text())):
            if ":" not in target:
                yield document, target


def anchors(document: Path) -> set[str]:
    """Those of a document's headings, as GitHub and GitLab make them."""
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

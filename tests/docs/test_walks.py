"""The walks of ARCHITECTURE.md name files and functions that exist."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOTS = {
    ".kt": ROOT / "ml2-sensors-aar/src/main/kotlin/dev/ml2sensors",
    ".py": ROOT / "host_receiver/ml2_receiver",
    ".c": ROOT,
    ".h": ROOT,
}
DEFINITION = {
    ".kt": r"\b(fun (<[^>]+> )?([\w.<>]+\.)?|class ){name}\b",
    ".py": r"\b(def|class) {name}\b",
    ".c": r"^\w[\w *]*\b{name}\(",
    ".h": r"^\w[\w *]*\b{name}\(",
}
WALKS = (ROOT / "ARCHITECTURE.md").read_text().partition("\n## Walks\n")[2].partition("\n## ")[0]
STEPS = sorted(set(re.findall(r"`([\w/]+\.\w+):(\w+)`", WALKS)))


def test_there_are_five_walks() -> None:
    assert len(re.findall(r"^\*\*", WALKS, re.MULTILINE)) == 5
    assert len(STEPS) > 40


@pytest.mark.parametrize(("file", "name"), STEPS, ids=":".join)
def test_a_step_exists(file: str, name: str) -> None:
    kind = Path(file).suffix
    source = (ROOTS[kind] / file).read_text()
    assert re.search(DEFINITION[kind].replace("{name}", name), source, re.MULTILINE)

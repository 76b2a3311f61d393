"""One message of a source file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from document import ROOT

HOLE = "…"


@dataclass(frozen=True)
class Message:
    """`text` has a HOLE for each thing that is filled in; `place` is file:line."""

    text: str
    place: str

    @classmethod
    def at(cls, file: Path, line: int, text: str) -> Message:
        text = re.sub(f"{HOLE}+", HOLE, " ".join(text.split()))
        return cls(text, f"{file.relative_to(ROOT)}:{line}")

"""Keeps payloads in a file, because a session has half a gigabyte and tests read only few."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sized
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Payloads(Sized):
    """The payloads of a topic; each iteration reads them from the file."""

    file: Path
    spans: list[tuple[int, int]] = field(default_factory=list)
    """The offset and the size of each payload in bytes."""

    def __len__(self) -> int:
        return len(self.spans)

    def __iter__(self) -> Iterator[bytes]:
        with self.file.open("rb", buffering=0) as file:
            for begin, size in self.spans:
                yield os.pread(file.fileno(), size, begin)

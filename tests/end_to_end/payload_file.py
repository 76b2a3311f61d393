"""Payloads kept in a file: a session has half a gigabyte of them, and few are looked at."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sized
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Payloads(Sized):
    """Those of a topic, read from the file whenever they are looked at."""

    file: Path
    spans: list[tuple[int, int]] = field(default_factory=list)
    """Where each begins, and its size in bytes."""

    def __len__(self) -> int:
        return len(self.spans)

    def __iter__(self) -> Iterator[bytes]:
        with self.file.open("rb", buffering=0) as file:
            for begin, size in self.spans:
                yield os.pread(file.fileno(), size, begin)

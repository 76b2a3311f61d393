"""Committed lists of what is public."""

import os
from difflib import unified_diff
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def assert_is_committed(found: str, dump: Path) -> None:
    """`make api` lets it write the list instead."""
    if "REWRITE_API" in os.environ:
        dump.write_text(found, "utf-8")
    committed = dump.read_text("utf-8")
    difference = unified_diff(committed.splitlines(), found.splitlines(), str(dump), "found", n=0)
    assert found == committed, "\n".join(["`make api` rewrites it:", *difference])

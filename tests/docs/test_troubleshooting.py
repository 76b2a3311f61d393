"""docs/troubleshooting.md has every message that a user can meet, and none that there is not."""

from __future__ import annotations

import re

from document import ROOT
from messages import all_messages

DOCUMENT = ROOT / "docs" / "troubleshooting.md"


def entries() -> list[str]:
    """The beginnings of messages, in the first columns of the tables."""
    rows = re.findall(r"^\| (`.*?`) \| .*\|$", DOCUMENT.read_text(), re.MULTILINE)
    return [entry for row in rows for entry in re.findall(r"`([^`]+)`", row)]


def test_every_message_has_an_entry() -> None:
    known = tuple(entries())
    missing = [f"{it.place}: {it.text}" for it in all_messages() if not it.text.startswith(known)]
    assert not missing, "\n".join(["not in docs/troubleshooting.md:", *missing])


def test_every_entry_is_of_a_message() -> None:
    texts = [it.text for it in all_messages()]
    stale = [it for it in entries() if not any(text.startswith(it) for text in texts)]
    assert not stale, "\n".join(["no source says:", *stale])

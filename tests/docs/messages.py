"""The messages that users meet, taken from the sources."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain

from document import ROOT
from message import HOLE, Message
from messages_of_others import messages_of_others
from messages_of_python import messages_of_python


def all_messages() -> list[Message]:
    """Each text once; without those that say nothing but what is filled in."""
    told = chain(messages_of_python(), messages_of_others(), _codes())
    found = {it.text: it for it in told}
    return [it for text, it in found.items() if re.search(r"[A-Za-z]{3}", text)]


def _codes() -> Iterator[Message]:
    """Of ERROR frames, as both sides show them."""
    protocol = ROOT / "PROTOCOL.md"
    rows = protocol.read_text().split("| code | meaning |")[1].split("\n\n")[0]
    for code in re.findall(r"^\| `(\w+)`", rows, re.MULTILINE):
        yield Message.at(protocol, 1, f"{code}: {HOLE}")

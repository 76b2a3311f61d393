"""Bytes that break the protocol, and what has to come of them: vectors/malformed."""

from typing import Any

import malformed_bodies
import malformed_custom
import malformed_data
import malformed_device
import malformed_pairing
import malformed_places
import malformed_receiver
from case_files import text
from frame_bytes import pascal
from sent_frames import Part

SIDES = {
    "receiver": (
        malformed_receiver,
        malformed_places,
        malformed_bodies,
        malformed_custom,
        malformed_data,
    ),
    "device": (malformed_device,),
    "pairing": (malformed_pairing,),
}


# Kinds that share a file with the kind that they answer or belong to.
FILE_OF = {
    "JOINED": "JOIN",
    "CONFIGURED": "CONFIGURE",
    "CHANNEL_END": "CHANNEL",
    "TIME_REQUEST": "TIME",
    "TIME_REPLY": "TIME",
    "FILLER": "LINK_TEST",
    "PONG": "PING",
    "PAIRED": "PAIR",
}


def files() -> dict[str, bytes]:
    """One file for each kind of frame and its answer, by the first frame that a case sends."""
    by_kind: dict[str, dict[str, Any]] = {}
    for side, modules in SIDES.items():
        for module in modules:
            for name, case in module.cases().items():
                vector = case.vector(side)
                by_kind.setdefault(_kind(vector["sent"]), {})[side.capitalize() + name] = vector
    return {
        f"{kind}.json": text(cases, "side given lane cut", "sent", "expect crc32", "why")
        for kind, cases in by_kind.items()
    }


def _kind(sent: list[Part]) -> str:
    match sent:
        case [{"frame": str(name)}, *_]:
            return pascal(FILE_OF.get(name, name))
    return "Unknown"

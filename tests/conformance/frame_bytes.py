"""Frames byte by byte, straight from the tables of PROTOCOL.md and from nothing else."""

import json
import struct
from typing import Any

KINDS = {
    "HELLO": 1,
    "WELCOME": 2,
    "JOIN": 3,
    "JOINED": 4,
    "CONFIGURE": 5,
    "CONFIGURED": 6,
    "CHANNEL": 7,
    "CHANNEL_END": 8,
    "START": 9,
    "DATA": 16,
    "TIME_REQUEST": 32,
    "TIME_REPLY": 33,
    "LINK_TEST": 40,
    "FILLER": 41,
    "STATUS": 48,
    "PING": 49,
    "PONG": 50,
    "ERROR": 51,
    "BYE": 52,
    "EVENT": 53,
    "PAIR_CHALLENGE": 60,
    "PAIR": 61,
    "PAIRED": 62,
    "OPEN": 96,
    "OPENED": 97,
    "CLOSE": 98,
    "CLOSED": 99,
    "TAKEN": 112,
    "MESSAGE": 128,
    "POSE": 129,
    "REQUEST": 130,
    "RESPONSE": 131,
    "FAILURE": 132,
}

KIB = 1024
BOUNDS = dict.fromkeys(KINDS, 4 * KIB) | {
    "HELLO": 64 * KIB,
    "WELCOME": 64 * KIB,
    "CONFIGURE": 64 * KIB,
    "CONFIGURED": 64 * KIB,
    "STATUS": 64 * KIB,
    "DATA": 16 * KIB * KIB,
    "FILLER": 64 * KIB,
    "PAIR": 16 * KIB,
    "TIME_REQUEST": 8,
    "TIME_REPLY": 24,
    "PING": 0,
    "PONG": 0,
    "TAKEN": 0,
    "MESSAGE": 16 * KIB * KIB,
    "POSE": 64,
    "REQUEST": 64 * KIB,
    "RESPONSE": 64 * KIB,
}


def header(
    kind: int,
    length: int,
    *,
    magic: bytes = b"M2",
    version: int = 1,
    flags: int = 0,
    channel: int = 0,
    sequence: int = 0,
    capture: int = 0,
    send: int = 0,
) -> bytes:
    """The 32 bytes in front of a body; `capture` and `send` in nanoseconds."""
    return b"".join(
        (
            magic,  # offset 0
            struct.pack("<B", version),  # 2
            struct.pack("<B", kind),  # 3
            struct.pack("<H", flags),  # 4
            struct.pack("<H", channel),  # 6
            struct.pack("<I", sequence),  # 8
            struct.pack("<I", length),  # 12
            struct.pack("<q", capture),  # 16
            struct.pack("<q", send),  # 24
        )
    )


def frame(name: str, body: bytes = b"", **fields: int) -> bytes:
    return header(KINDS[name], len(body), **fields) + body  # type: ignore[arg-type]


def json_frame(name: str, value: Any) -> bytes:
    return frame(name, json_bytes(value))


def json_bytes(value: Any) -> bytes:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).encode()


def pascal(name: str) -> str:
    """`device_id` and `CHANNEL_END` as they stand in case names: DeviceId, ChannelEnd."""
    return "".join(word.capitalize() for word in name.replace(".", "_").split("_"))

"""Frames that every reader accepts and every writer can write: vectors/wire."""

import struct
from typing import Any

from bodies import (
    ADAPTED_STREAMS,
    BYE,
    CHANNEL,
    CLOCK_DETAILS,
    CONFIGURE,
    CONFIGURED,
    CUSTOM,
    EVENT,
    HELLO,
    JOIN,
    LINK_TEST,
    PAIR,
    PAIR_CHALLENGE,
    PAIRED,
    STATUS,
    STREAM_STATES,
    STRING_PAYLOAD,
    WELCOME,
    Body,
)
from case_files import text
from frame_bytes import KINDS, UNKNOWN_BOUND, header, json_bytes, pascal
from pieces import hex_piece, split

JOIN_SENSORS = JOIN | {
    "session": WELCOME["session"],
    "ticket": WELCOME["tickets"]["sensors"],
}
ERROR = {"code": "busy", "message": "another headset is connected", "fatal": True}
INT64_MIN, INT64_MAX = -(2**63), 2**63 - 1
Frame = dict[str, Any]
# Case name -> sender, lane, why, frames.
Case = tuple[str, str, str, list[Frame]]


def read(name: str, **parts: Any) -> Frame:
    """A frame of a known kind; the parts are header fields and one of json, time, hex."""
    return {"name": name, "kind": KINDS[name], **parts}


def skipped(kind: int, body: bytes = b"") -> Frame:
    return {"name": None, "kind": kind, "body": body}


def body_bytes(part: Frame) -> bytes:
    if "body" in part:
        return bytes(part["body"])
    if "text" in part:
        return str(part["text"]).encode()
    if "json" in part:
        return json_bytes(part["json"])
    if "time" in part:
        return b"".join(struct.pack("<q", nanos) for nanos in part["time"].values())
    return bytes.fromhex(part.get("hex", ""))


def data(channel: int, sequence: int, **parts: Any) -> Frame:
    return read("DATA", channel=channel, sequence=sequence, hex=STRING_PAYLOAD.hex(), **parts)


def body_of(name: str, length: int) -> dict[str, str]:
    """A JSON body of exactly `length` bytes, for kinds with one string."""
    return {name: "x" * (length - len(json_bytes({name: ""})))}


def nested(depth: int) -> Any:
    return {"deeper": nested(depth - 1)} if depth > 1 else {}


# Kind, sender, lane, body, why.
JSON_KINDS: list[tuple[str, str, str, Body, str]] = [
    ("HELLO", "device", "control", HELLO, "The device introduces itself."),
    ("WELCOME", "receiver", "control", WELCOME, "Tickets, and counts beyond 32 bits."),
    ("JOIN", "device", "sensors", JOIN_SENSORS, "A lane's ticket."),
    ("JOINED", "receiver", "sensors", {"lane": "sensors"}, "The lane is open."),
    ("CONFIGURE", "receiver", "control", CONFIGURE, "Streams with and without values."),
    ("CONFIGURED", "device", "control", CONFIGURED, "One applied, one adjusted, one refused."),
    ("CHANNEL", "device", "control", CHANNEL, "A topic gets its number."),
    ("CHANNEL_END", "device", "control", {"id": 7}, "The topic has ended."),
    ("START", "receiver", "control", {"request": 1}, "The publishers exist."),
    ("LINK_TEST", "receiver", "control", LINK_TEST, "As much filler as can be asked for."),
    ("STATUS", "device", "control", STATUS, "Drops by reason, and a clock far from the host's."),
    ("EVENT", "device", "control", EVENT, "Something happened to the device."),
    ("ERROR", "receiver", "control", ERROR, "A fatal ERROR."),
    ("BYE", "receiver", "control", BYE, "The receiver says goodbye, too."),
    ("PAIR_CHALLENGE", "receiver", "pairing", PAIR_CHALLENGE, "The first frame of pairing."),
    ("PAIR", "device", "pairing", PAIR, "Answers PairChallenge to a receiver of vectors/pairing."),
    ("PAIRED", "receiver", "pairing", PAIRED, "Both know each other's certificate."),
]


def kinds() -> dict[str, Case]:
    """One case for every kind."""
    cases: dict[str, Case] = {
        pascal(name): (sender, lane, why, [read(name, json=body)])
        for name, sender, lane, body, why in JSON_KINDS
    }
    t1, t2, t3 = 5_000_000_001, 1_700_000_000_000_000_100, 1_700_000_000_000_000_300
    return cases | {
        "WelcomeUnknownInstance": (
            "receiver",
            "control",
            "The receiver does not know the instance, so it cannot know what arrived.",
            [read("WELCOME", json=WELCOME | {"received": None})],
        ),
        "Data": (
            "device",
            "sensors",
            "std_msgs/String 'hi': encapsulation, length 3 with its zero, h, i, zero.",
            [data(7, 41, capture=1_700_000_000_123_456_789, send=1_700_000_000_125_000_000)],
        ),
        "TimeRequest": (
            "device",
            "time",
            "The sender does not know ROS time yet, so send is 0.",
            [read("TIME_REQUEST", time={"t1": t1})],
        ),
        "TimeReply": (
            "receiver",
            "time",
            "t1 comes back with the receiver's two times.",
            [read("TIME_REPLY", send=t3, time={"t1": t1, "t2": t2, "t3": t3})],
        ),
        "ConfigureFramePrefix": (
            "receiver",
            "control",
            "Frame ids of several headsets told apart.",
            [read("CONFIGURE", json=CONFIGURE | {"frame_prefix": "robot1/"})],
        ),
        "ConfigureLink": (
            "receiver",
            "control",
            "Images give way to the link.",
            [read("CONFIGURE", json=CONFIGURE | {"link": {"adapts": True}})],
        ),
        "ConfigureLinkBound": (
            "receiver",
            "control",
            "Images give way to a bound, which is not a whole number.",
            [
                read(
                    "CONFIGURE",
                    json=CONFIGURE | {"link": {"adapts": True, "most_mbit_per_s": 0.5}},
                )
            ],
        ),
        "ConfigureLinkFixed": (
            "receiver",
            "control",
            "Images do not give way, and never send more than the bound.",
            [
                read(
                    "CONFIGURE",
                    json=CONFIGURE | {"link": {"adapts": False, "most_mbit_per_s": 100}},
                )
            ],
        ),
        "ChannelCustom": (
            "device",
            "control",
            "A topic that the device has named.",
            [read("CHANNEL", json=CUSTOM)],
        ),
        "StartChannels": (
            "receiver",
            "control",
            "How many CHANNELs had been seen.",
            [read("START", json={"request": 1, "channels": 5})],
        ),
        "EventAge": (
            "device",
            "control",
            "It happened before there was a receiver to tell.",
            [read("EVENT", json=EVENT | {"age_s": 12.5})],
        ),
        "ErrorOfChannel": (
            "receiver",
            "control",
            "A topic whose type is not there; the session goes on.",
            [
                read(
                    "ERROR",
                    json={
                        "code": "channel",
                        "message": "there is no package my_msgs",
                        "fatal": False,
                        "channel": 40,
                    },
                )
            ],
        ),
        "LinkTestLeast": (
            "receiver",
            "control",
            "As little filler as can be asked for.",
            [read("LINK_TEST", json={"bytes": 1})],
        ),
        "Filler": (
            "device",
            "link_test",
            "Noise, and the end of a test, which has no body.",
            [read("FILLER", send=5, hex="6b1f00ff"), read("FILLER", send=6)],
        ),
        "StatusClockDetails": (
            "device",
            "control",
            "All optional keys of a clock, which is held over a broken link.",
            [read("STATUS", json=STATUS | {"clock": STATUS["clock"] | CLOCK_DETAILS})],
        ),
        "StatusThermal": (
            "device",
            "control",
            "A headset that says how hot it is.",
            [read("STATUS", json=STATUS | {"thermal": "severe"})],
        ),
        "StatusStreams": (
            "device",
            "control",
            "Every state that a stream can have.",
            [read("STATUS", json=STATUS | {"streams": STREAM_STATES})],
        ),
        "StatusAdapted": (
            "device",
            "control",
            "Streams whose quality, rate or both are lowered.",
            [read("STATUS", json=STATUS | {"streams": ADAPTED_STREAMS})],
        ),
        "StatusFinal": (
            "device",
            "control",
            "The final STATUS and BYE, back to back.",
            [read("STATUS", json=STATUS | {"final": True}), read("BYE", json=BYE)],
        ),
        "Ping": ("device", "control", "PING has no body.", [read("PING")]),
        "Pong": ("receiver", "control", "PONG has no body.", [read("PONG")]),
    }


def edges() -> dict[str, Case]:
    """Values at the ends of their ranges, and what readers have to pass over."""
    return {
        "HeaderMaximum": (
            "device",
            "sensors",
            "Every field of the header at its maximum; readers ignore flags.",
            [
                data(65535, 2**32 - 1, flags=65535, capture=INT64_MAX, send=INT64_MAX),
            ],
        ),
        "HeaderMinimum": (
            "device",
            "sensors",
            "Negative times, and a sequence that has wrapped to 0.",
            [data(1, 0, capture=INT64_MIN, send=INT64_MIN), data(1, 1, capture=-1, send=-1)],
        ),
        "TimeExtremes": (
            "receiver",
            "time",
            "Times are signed.",
            [read("TIME_REPLY", time={"t1": INT64_MIN, "t2": -1, "t3": INT64_MAX})],
        ),
        "NonAsciiName": (
            "device",
            "control",
            "Two-, three- and four-byte UTF-8; length counts bytes.",
            [read("HELLO", json=HELLO | {"name": "Größe 眼鏡 👓"})],
        ),
        "EscapedJson": (
            "device",
            "control",
            "White space and escapes, a surrogate pair among them, are JSON too.",
            [
                read(
                    "BYE",
                    json={"reason": "Größe \n 👓"},
                    text=' { "reason" :\r\n\t"Gr\\u00f6\\u00dfe \\n \\ud83d\\udc53" } ',
                )
            ],
        ),
        "UnknownKeys": (
            "device",
            "control",
            "Keys of a later minor version are ignored at every level.",
            [
                read(
                    "HELLO",
                    json={"later": {"a": [1, None]}}
                    | HELLO
                    | {"capabilities": HELLO["capabilities"] | {"later": True}},
                ),
            ],
        ),
        "DeepestJson": (
            "device",
            "control",
            "16 levels, the outermost object being the first.",
            [read("BYE", json=BYE | {"later": nested(15)})],
        ),
        "LargestBye": (
            "device",
            "control",
            "A body as long as its kind allows.",
            [read("BYE", json=body_of("reason", 4096))],
        ),
        "UnknownKindSkipped": (
            "device",
            "control",
            "An unknown kind between two known ones is skipped with its body.",
            [read("PING"), skipped(99, b"M2 from a later version"), read("PONG")],
        ),
        "LargestUnknownKind": (
            "device",
            "control",
            "An unknown kind of 64 KiB is skipped.",
            [skipped(255, bytes(UNKNOWN_BOUND)), read("PING")],
        ),
        "ReservedKindsSkipped": (
            "receiver",
            "control",
            "The kinds reserved for data to the device are unknown in version 1.",
            [skipped(128, b"\x00\x01\x00\x00"), skipped(191), read("PING")],
        ),
        "UnknownEmptyKinds": (
            "device",
            "sensors",
            "Kinds 0 and 17, without a body, around DATA.",
            [skipped(0), data(3, 5), skipped(17), data(3, 6)],
        ),
    }


def frame_parts(part: Frame) -> tuple[Frame, bytes, bytes]:
    """Returns the expected frame, and the header and body that hold it."""
    body = body_bytes(part)
    fields = {key: part.get(key, 0) for key in ("flags", "channel", "sequence", "capture", "send")}
    found = {"name": part["name"], "kind": part["kind"], "length": len(body)} | fields
    found |= {key: part[key] for key in ("json", "time", "hex") if key in part}
    return found, header(part["kind"], len(body), **fields), body


def files() -> dict[str, bytes]:
    cases = {name: vector(*case) for name, case in (kinds() | edges()).items()}
    return {"frames.json": text(cases, "sender lane", "why")}


def vector(sender: str, lane: str, why: str, frames: list[Frame]) -> dict[str, Any]:
    parts = [frame_parts(part) for part in frames]
    pieces = [piece for _, head, body in parts for piece in (hex_piece(head), *split(body))]
    found = [found for found, _, _ in parts]
    return {"sender": sender, "lane": lane, "why": why, "frames": found, "bytes": pieces}

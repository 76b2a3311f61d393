"""The input of a receiver from a broken, older, newer or malicious device."""

from bodies import (
    BYE,
    CHANNEL,
    CONFIGURED_LIVE,
    EVENT,
    HELLO,
    JOIN,
    STATUS,
    STRING_PAYLOAD,
)
from frame_bytes import (
    BOUNDS,
    KIB,
    KINDS,
    SENSORS_DATA_BOUND,
    UNKNOWN_BOUND,
    frame,
    header,
    json_bytes,
    pascal,
)
from malformed_case import Case, error, over_bound

# Bodies by kind, and the first state and lane in which a device may send them.
DEVICE_KINDS = {
    "HELLO": (HELLO, "connected", "control"),
    "JOIN": (JOIN, "connected", "sensors"),
    "CONFIGURED": (CONFIGURED_LIVE, "configuring", "control"),
    "CHANNEL": (CHANNEL, "configuring", "control"),
    "CHANNEL_END": ({"id": CHANNEL["id"]}, "streaming", "control"),
    "STATUS": (STATUS, "streaming", "control"),
    "EVENT": (EVENT, "streaming", "control"),
    "BYE": (BYE, "streaming", "control"),
}


def data(channel: int, sequence: int = 0, body: bytes = STRING_PAYLOAD) -> bytes:
    return frame("DATA", body, channel=channel, sequence=sequence)


def headers() -> dict[str, Case]:
    """The first 32 bytes of a connection."""
    control = "connected", "control"
    hello = json_bytes(HELLO)
    return {
        "BadMagic": Case(
            *control,
            b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
            error("malformed"),
            "A browser is no headset.",
        ),
        "SwappedMagic": Case(
            *control,
            header(1, len(hello), magic=b"2M") + hello,
            error("malformed"),
            "The magic is little endian.",
        ),
        "NewerVersion": Case(
            *control,
            header(1, len(hello), version=2) + hello,
            error("version"),
            "A newer major version is answered in a frame of version 1.",
        ),
        "VersionZero": Case(
            *control,
            header(1, len(hello), version=0) + hello,
            error("version"),
            "There was no version 0.",
        ),
        "MagicBeforeVersionAndLength": Case(
            *control,
            header(1, 2**32 - 1, magic=b"XX", version=9),
            error("malformed"),
            "The magic is checked first.",
        ),
        "VersionBeforeLength": Case(
            *control,
            header(1, 2**32 - 1, version=9),
            error("version"),
            "Bounds are those of a version, so the version is checked before them.",
        ),
        "LengthBeforeKind": Case(
            *control,
            header(KINDS["BYE"], 4 * KIB + 1),
            error("too_large"),
            "BYE may not come first, but its length is checked before that.",
        ),
        "LyingLength": Case(
            *control,
            header(1, 2**32 - 1) + hello,
            error("too_large"),
            "4 GiB are claimed and must not be allocated.",
        ),
        "HelloThatNeverEnds": Case(
            *control,
            header(1, 64 * KIB) + hello,
            error("timeout"),
            "A length within the bound whose bytes do not come.",
        ),
        "Silent": Case(*control, b"", error("timeout"), "A peer that connects and says nothing."),
        "SilentInHeader": Case(
            *control, header(1, 0)[:31], error("timeout"), "One byte of the header is missing."
        ),
    }


def bounds() -> dict[str, Case]:
    """One byte more than each kind may have; only the header is sent."""
    places = {name: (given, lane) for name, (_, given, lane) in DEVICE_KINDS.items()} | {
        "PING": ("streaming", "control"),
        "PONG": ("streaming", "control"),
        "ERROR": ("streaming", "control"),
        "DATA": ("streaming", "world_left"),
        "TIME_REQUEST": ("streaming", "time"),
        "FILLER": ("streaming", "link_test"),
    }
    cases: dict[str, Case] = {}
    for name, place in places.items():
        cases |= over_bound(name, header(KINDS[name], BOUNDS[name] + 1), *place, BOUNDS[name])
    small = header(KINDS["DATA"], SENSORS_DATA_BOUND + 1, channel=CHANNEL["id"])
    cases |= {
        "Sensors" + k: v
        for k, v in over_bound("DATA", small, "streaming", "sensors", SENSORS_DATA_BOUND).items()
    }
    for number in (0, 128, 255):
        sent = header(number, UNKNOWN_BOUND + 1)
        cases |= over_bound(f"KIND_{number}", sent, "streaming", "control", UNKNOWN_BOUND)
    return cases


def skips() -> dict[str, Case]:
    """Unknown kinds, on every sort of lane."""
    sent = header(99, 5) + b"later" + header(128, 0) + header(255, 0)
    return {
        f"UnknownKindsOn{pascal(lane)}": Case(
            "streaming", lane, sent, {"skipped": 3}, "Unknown kinds are skipped and counted."
        )
        for lane in ("control", "time", "sensors", "link_test", "world_left")
    }


def cases() -> dict[str, Case]:
    return headers() | bounds() | skips()

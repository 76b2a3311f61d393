"""vectors/wire, read and written by the receiver's own frames and messages."""

import json
import struct
from typing import Any

import pytest

from case_files import load
from frame_bytes import json_bytes
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire import messages, opening_bodies, pairing_bodies
from ml2_receiver.wire.frame import Frame, FrameParser, encode_frame
from ml2_receiver.wire.kinds import OPENING, Kind, Side

CASES = load("wire")
HEADER_BYTES = 32
FLAGS = slice(4, 6)
OPENERS = {"HELLO", "JOIN"}
BODIES = (messages, opening_bodies, pairing_bodies)


def parse(case: dict[str, Any], binary: bytes, piece_bytes: int) -> list[tuple[Frame, bytes]]:
    """All frames that a parser finds when at most `piece_bytes` arrive at a time."""
    lane = load_table().lane(case["lane"])
    if case["frames"][0]["name"] in OPENERS:
        lane = OPENING
    side = Side.DEVICE if case["sender"] == "device" else Side.RECEIVER
    parser = FrameParser(side, lane, has_openings=case.get("ros", False))
    rest, frames = memoryview(binary), []
    while rest:
        buffer = parser.get_buffer()
        count = min(piece_bytes, len(buffer), len(rest))
        buffer[:count] = rest[:count]
        rest = rest[count:]
        if found := parser.buffer_updated(count):
            frames.append((found, bytes(found.body)))
    assert parser.is_between_frames
    return frames


@pytest.mark.parametrize("piece_bytes", [1, 7, 1 << 20])
@pytest.mark.parametrize("name", CASES)
def test_frames_are_read_however_they_are_cut_up(name: str, piece_bytes: int) -> None:
    _, case, binary = CASES[name]
    found = parse(case, binary, piece_bytes)
    assert len(found) == len(case["frames"])
    for (header, _), body, expected in zip(*zip(*found, strict=True), case["frames"], strict=True):
        fields = (
            header.kind,
            header.length,
            header.flags,
            header.channel,
            header.sequence,
        )
        keys = ("kind", "length", "flags", "channel", "sequence")
        assert fields == tuple(expected[key] for key in keys)
        assert (header.capture_ns, header.send_ns) == (
            expected["capture"],
            expected["send"],
        )
        if expected["name"]:
            assert header.kind == Kind[expected["name"]]
            assert_body(expected, body)


def assert_body(expected: dict[str, Any], body: bytes) -> None:
    if "json" in expected:
        assert json.loads(body) == expected["json"]
    if "time" in expected:
        assert [nanos for (nanos,) in struct.iter_unpack("<q", body)] == [
            *expected["time"].values()
        ]
    if "hex" in expected:
        assert body.hex() == expected["hex"]


@pytest.mark.parametrize("name", CASES)
def test_frames_are_written_byte_for_byte(name: str) -> None:
    _, case, binary = CASES[name]
    for expected in case["frames"]:
        size = HEADER_BYTES + expected["length"]
        original, binary = bytearray(binary[:size]), binary[size:]
        original[FLAGS] = bytes(2)
        if expected["name"] is None:
            continue
        written = encode_frame(
            Kind[expected["name"]],
            bytes(original[HEADER_BYTES:]),
            channel=expected["channel"],
            sequence=expected["sequence"],
            capture_ns=expected["capture"],
            send_ns=expected["send"],
        )
        assert written == original


@pytest.mark.parametrize("name", CASES)
def test_bodies_become_messages_and_the_same_json_again(name: str) -> None:
    case = CASES[name].case
    for expected in case["frames"]:
        if "json" not in expected:
            continue
        name = expected["name"].title().replace("_", "")
        body_class = next(getattr(it, name) for it in BODIES if hasattr(it, name))
        message = body_class.parse(json_bytes(expected["json"]))
        assert without_ignored(json.loads(message.to_bytes())) == without_ignored(expected["json"])


def test_poses_are_read_and_written() -> None:
    body = CASES["Pose"].data[HEADER_BYTES:]
    pose = opening_bodies.Pose.parse(body)
    assert pose == (1.0, -0.5, 0.0, 0.0, 0.0, 1.0, 0.0, 0)
    assert pose.to_bytes() == body


def without_ignored(value: Any) -> Any:
    """A body without the vectors' unknown key."""
    if isinstance(value, dict):
        return {key: without_ignored(item) for key, item in value.items() if key != "later"}
    return value

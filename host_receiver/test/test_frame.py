import struct
import tracemalloc
from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ml2_receiver.errors import ErrorCode, ProtocolError
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.frame import HEADER_BYTES, Frame, FrameParser, encode_frame
from ml2_receiver.wire.kinds import OPENING, Kind, Side

# PROTOCOL.md's table, written down a second time: kind, senders, lanes, greatest length.
TABLE = [
    (1, "device", "opening", 65536),
    (2, "receiver", "control", 65536),
    (3, "device", "opening", 4096),
    (4, "receiver", "time sensors link_test image bulk", 4096),
    (5, "receiver", "control", 65536),
    (6, "device", "control", 65536),
    (7, "device", "control", 4096),
    (8, "device", "control", 4096),
    (9, "receiver", "control", 4096),
    (16, "device", "sensors", 65536),
    (16, "device", "image bulk", 16 << 20),
    (32, "device", "time", 8),
    (33, "receiver", "time", 24),
    (40, "receiver", "control", 4096),
    (41, "device", "link_test", 65536),
    (48, "device", "control", 65536),
    (49, "device receiver", "control", 0),
    (50, "device receiver", "control", 0),
    (51, "device receiver", "opening control time sensors link_test image bulk pairing", 4096),
    (52, "device receiver", "control", 4096),
    (53, "device", "control", 4096),
    (60, "receiver", "pairing", 4096),
    (61, "device", "pairing", 16384),
    (62, "receiver", "pairing", 4096),
]
SIDES = {"device": Side.DEVICE, "receiver": Side.RECEIVER}
LANES = {it: load_table().lane(it) for it in ("control", "time", "link_test", "pairing")}
LANES |= {it.name: it.lane(it.name) for it in load_table().lane_classes.values()}
LANES |= {"opening": OPENING}
IMAGE = LANES["image"]
PLACES = [
    (kind, side, lane, bound)
    for kind, sides, lanes, bound in TABLE
    for side in sides.split()
    for lane in lanes.split()
]
KIB, MIB = 1 << 10, 1 << 20


def header(
    kind: int, length: int, *, magic: int = 0x324D, version: int = 1, channel: int = 0
) -> bytes:
    return struct.pack("<HBBHHIIqq", magic, version, kind, 0, channel, 0, length, 0, 0)


def feed(parser: FrameParser, data: bytes) -> list[Frame]:
    """Returns the frames of `data`, with copies of their payloads."""
    return [Frame(it.header, bytearray(it.body)) for it in parser.feed(memoryview(data))]


def feed_chunks(parser: FrameParser, chunks: Iterable[bytes]) -> list[Frame]:
    return [frame for chunk in chunks for frame in feed(parser, chunk)]


def outcome(parser: FrameParser, data: bytes) -> ErrorCode | None:
    """The code of the error that `data` is, None if it is none."""
    try:
        feed(parser, data)
    except ProtocolError as error:
        return error.code
    return None


def code_of(parser: FrameParser, data: bytes) -> ErrorCode:
    with pytest.raises(ProtocolError) as raised:
        feed(parser, data)
    return raised.value.code


def data_frame(payload: bytes, sequence: int = 0) -> bytes:
    return encode_frame(Kind.DATA, payload, channel=7, sequence=sequence, capture_ns=-1, send_ns=2)


def test_a_frame_is_its_header_and_body_in_little_endian() -> None:
    data = encode_frame(
        Kind.DATA,
        b"\xaa\xbb",
        channel=0x0102,
        sequence=0x03040506,
        capture_ns=0x0708090A0B0C0D0E,
        send_ns=-2,
    )
    assert data.hex(" ") == (
        "4d 32 01 10 00 00 02 01 06 05 04 03 02 00 00 00 "
        "0e 0d 0c 0b 0a 09 08 07 fe ff ff ff ff ff ff ff aa bb"
    )
    (frame,) = feed(FrameParser(Side.DEVICE, IMAGE), data)
    assert frame.body == b"\xaa\xbb"
    assert frame.header[2:] == (16, 0, 0x0102, 0x03040506, 2, 0x0708090A0B0C0D0E, -2)


def test_a_body_above_its_kinds_bound_cannot_be_encoded() -> None:
    with pytest.raises(ValueError, match="PING takes 0 B, got 1"):
        encode_frame(Kind.PING, b"x")


@pytest.mark.parametrize(("kind", "side", "lane", "bound"), PLACES)
def test_every_kind_is_taken_up_to_its_bound_and_refused_above(
    kind: int, side: str, lane: str, bound: int
) -> None:
    parser = FrameParser(SIDES[side], LANES[lane])
    (frame,) = feed(parser, header(kind, bound) + bytes(bound))
    assert frame.header.kind == kind
    assert len(frame.body) == bound
    assert code_of(parser, header(kind, bound + 1)) == "too_large"


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("lane", LANES)
def test_a_known_kind_is_refused_wherever_the_table_does_not_name_it(side: str, lane: str) -> None:
    for kind in {kind for kind, *_ in TABLE}:
        length = {32: 8, 33: 24}.get(kind, 0)
        parser = FrameParser(SIDES[side], LANES[lane])
        if any((kind, side, lane) == place[:3] for place in PLACES):
            assert len(feed(parser, header(kind, length) + bytes(length))) == 1
        else:
            assert code_of(parser, header(kind, length)) == "unexpected"


@pytest.mark.parametrize("lane", sorted(set(LANES) - {"opening"}))
def test_unknown_kinds_are_taken_up_to_64_kib(lane: str) -> None:
    known = {kind for kind, *_ in TABLE}
    for kind in set(range(256)) - known:
        parser = FrameParser(Side.DEVICE, LANES[lane])
        assert len(feed(parser, header(kind, 3) + b"abc")) == 1
        assert code_of(parser, header(kind, 64 * KIB + 1)) == "too_large"


@pytest.mark.parametrize("version", [0, 2, 255])
def test_another_version_is_named(version: int) -> None:
    parser = FrameParser(Side.DEVICE)
    with pytest.raises(ProtocolError, match=f"expected version 1, found {version}") as raised:
        feed(parser, header(1, 0, version=version))
    assert raised.value.code == "version"


@given(
    payloads=st.lists(st.binary(max_size=200), max_size=8),
    cuts=st.lists(st.integers(0, 2000), max_size=20),
)
def test_frames_do_not_depend_on_how_the_bytes_are_cut(
    payloads: list[bytes], cuts: list[int]
) -> None:
    stream = b"".join(data_frame(payload, number) for number, payload in enumerate(payloads))
    ends = [*sorted(min(cut, len(stream)) for cut in cuts), len(stream)]
    chunks = [stream[begin:end] for begin, end in zip([0, *ends], ends, strict=False)]
    frames = feed_chunks(FrameParser(Side.DEVICE, IMAGE), chunks)
    assert [frame.body for frame in frames] == payloads
    assert [frame.header.sequence for frame in frames] == list(range(len(payloads)))


@given(garbage=st.binary(max_size=300), lane=st.sampled_from(sorted(LANES)))
def test_garbage_is_a_protocol_error_or_frames(garbage: bytes, lane: str) -> None:
    assert outcome(FrameParser(Side.DEVICE, LANES[lane]), garbage) in (None, "malformed", "version")


@given(
    kind=st.integers(0, 255),
    length=st.integers(0, 2**32 - 1),
    rest=st.binary(max_size=64),
    lane=st.sampled_from(sorted(LANES)),
)
def test_any_header_is_a_protocol_error_or_frames(
    kind: int, length: int, rest: bytes, lane: str
) -> None:
    outcome(FrameParser(Side.DEVICE, LANES[lane]), header(kind, length) + rest)


@pytest.mark.parametrize("length", [16 * MIB, 16 * MIB + 1, 2**32 - 1])
def test_a_claimed_length_is_not_allocated_before_its_bytes_come(length: int) -> None:
    parser = FrameParser(Side.DEVICE, IMAGE)
    tracemalloc.start()
    assert outcome(parser, header(16, length) + bytes(1000)) == (
        None if length == 16 * MIB else "too_large"
    )
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak_bytes < 1.25 * MIB


def test_a_body_kept_from_before_adds_nothing_to_what_is_ahead_of_the_bytes() -> None:
    parser = FrameParser(Side.DEVICE, IMAGE)
    (before,) = parser.feed(memoryview(data_frame(bytes(11))))
    assert len(before.body) == 11
    large = data_frame(bytes(16 * MIB))
    assert list(parser.feed(memoryview(large)[:HEADER_BYTES])) == []
    assert len(parser.get_buffer()) == MIB


def test_a_large_payload_costs_little_more_than_itself() -> None:
    parser = FrameParser(Side.DEVICE, IMAGE)
    stream = data_frame(bytes(16 * MIB))
    tracemalloc.start()
    (count,) = [len(frame.body) for frame in parser.feed(memoryview(stream))]
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert count == 16 * MIB
    assert peak_bytes < 20 * MIB


def test_the_payload_is_one_bytearray_that_is_reused_without_allocation() -> None:
    parser = FrameParser(Side.DEVICE, IMAGE)
    image = data_frame(bytes(MIB))
    (first,) = parser.feed(memoryview(image))
    tracemalloc.start()
    for _ in range(10):
        (frame,) = parser.feed(memoryview(image))
        assert frame.body is first.body
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert isinstance(first.body, bytearray)
    assert peak_bytes < 4 * KIB


def test_a_view_is_of_no_use_after_it_was_filled() -> None:
    parser = FrameParser(Side.DEVICE)
    view = parser.get_buffer()
    parser.buffer_updated(0)
    with pytest.raises(ValueError, match="released"):
        view[0]

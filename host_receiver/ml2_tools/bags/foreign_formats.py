"""Recognises files that are not MCAP, by their beginning or their name."""

from pathlib import Path

from mcap.writer import MCAP0_MAGIC

from ml2_receiver.errors import RecordingError
from ml2_receiver.wire.frame import CDR_ENCAPSULATION

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_TO_MCAP = "Convert it to MCAP with `{}`."
_SQLITE = "is in rosbag2's SQLite format", _TO_MCAP.format("ros2 bag convert")
_ROS_1 = "is a recording of ROS 1", _TO_MCAP.format("rosbags-convert")
_PACKED = "is compressed as a whole (compression_mode FILE)"
_FORMATS = {
    b"SQLite f": _SQLITE,
    b"#ROSBAG ": _ROS_1,
    ZSTD_MAGIC: (_PACKED, "Unpack it into another file: zstd --decompress --stdout {file}"),
}
_ENDINGS = {
    ".db3": _SQLITE,
    ".db3.zstd": _SQLITE,
    ".mcap.zstd": (_PACKED, "Unpack it: zstd --decompress {file}"),
    ".bag": _ROS_1,
}
_HEADER_BYTES = len(CDR_ENCAPSULATION)
_LITTLE_ENDIAN = CDR_ENCAPSULATION[1]
# The second byte of a payload, by RTPS and XTypes.
_REPRESENTATIONS = {
    0: "big-endian CDR",
    **dict.fromkeys((2, 3), "CDR with parameter lists"),
    4: "XML",
    **dict.fromkeys(range(6, 12), "XCDR2"),
}


def check_format(file: Path, beginning: bytes) -> None:
    """Checks the first 8 bytes of a file.

    Raises:
        RecordingError: they are not those of an MCAP file, or of a truncated one; says of what
            they are.
    """
    if not beginning:
        raise RecordingError(
            f"{file} is empty: it has 0 B",
            hint="The program that wrote it ended before its first message was on disk.",
        )
    for magic, said in _FORMATS.items():
        if beginning.startswith(magic):
            raise _unsupported(file, *said)
    if not MCAP0_MAGIC.startswith(beginning):
        begin = "zeros" if not any(beginning) else repr(beginning)
        raise RecordingError(f"{file} is broken: not a valid MCAP file, it begins with {begin}")


def unsupported_by_name(file: Path) -> RecordingError | None:
    """Returns what to say of a file with the ending of a format that is not read, else None."""
    for ending, said in _ENDINGS.items():
        if file.name.lower().endswith(ending):
            return _unsupported(file, *said)
    return None


def plain_cdr(file: Path, topic: str, payload: bytes) -> bytes:
    """Returns a payload with the header that ROS 2 gives it; others have options in it.

    Raises:
        RecordingError: it is of another representation, by the header of RTPS.
    """
    if payload.startswith(CDR_ENCAPSULATION) or len(payload) < _HEADER_BYTES or payload[0]:
        return payload
    if payload[1] == _LITTLE_ENDIAN:
        return CDR_ENCAPSULATION + payload[_HEADER_BYTES:]
    kind = _REPRESENTATIONS.get(payload[1], f"representation {payload[1]}")
    raise RecordingError(
        f"not supported: {file} has {topic} in {kind}; little-endian CDR is",
        hint="Convert it on the machine that recorded it.",
    )


def _unsupported(file: Path, what: str, hint: str) -> RecordingError:
    return RecordingError(f"not supported: {file.name} {what}", hint=hint.format(file=file))

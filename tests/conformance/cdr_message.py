"""A ROS 2 message written field by field, at once as CDR and as the JSON that says the same.

Written to be checked by hand against the .msg files and the CDR rules, so it uses struct alone.
"""

import math
import struct
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from pieces import PATTERN, Piece, hex_piece

ENCAPSULATION = bytes([0x00, 0x01, 0x00, 0x00])  # plain CDR, little-endian, no options


class Message:
    """Fields are written in the order of the calls; a field's name is that of the .msg file."""

    def __init__(self, ros_type: str) -> None:
        self._bytes = bytearray(ENCAPSULATION)
        self._fields: dict[str, Any] = {}
        self._pattern: list[Piece] = []
        self._vector: dict[str, Any] = {"type": ros_type, "message": self._fields}

    def vector(self) -> dict[str, Any]:
        prefix = bytes(self._bytes[: self._vector.get("prefix_size")])
        pieces = [hex_piece(prefix), *self._pattern]
        return self._vector | {"size": len(self._bytes), "bytes": pieces}

    def bool(self, name: str, value: bool) -> None:
        self._number("B", value)
        self._fields[name] = value

    def uint8(self, name: str, value: int) -> None:
        self._number("B", value)
        self._fields[name] = value

    def int32(self, name: str, value: int) -> None:
        self._number("i", value)
        self._fields[name] = value

    def uint32(self, name: str, value: int) -> None:
        self._number("I", value)
        self._fields[name] = value

    def uint64(self, name: str, value: int) -> None:
        self._number("Q", value)
        self._fields[name] = value

    def float32(self, name: str, value: float) -> None:
        self._float32(value)
        self._fields[name] = json_float(value)

    def float64(self, name: str, value: float) -> None:
        self._number("d", value)
        self._fields[name] = json_float(value)

    def string(self, name: str, value: str) -> None:
        text = value.encode() + b"\0"
        self._number("I", len(text))
        self._bytes += text
        self._fields[name] = value

    def float32_sequence(self, name: str, values: Sequence[float]) -> None:
        self._number("I", len(values))
        for value in values:
            self._float32(value)
        self._fields[name] = [json_float(value) for value in values]

    def int32_sequence(self, name: str, values: Sequence[int]) -> None:
        self._number("I", len(values))
        for value in values:
            self._number("i", value)
        self._fields[name] = list(values)

    def float64_sequence(self, name: str, values: Sequence[float]) -> None:
        self._number("I", len(values))
        self.float64_array(name, values)

    def float64_array(self, name: str, values: Sequence[float]) -> None:
        for value in values:
            self._number("d", value)
        self._fields[name] = [json_float(value) for value in values]

    def pattern_bytes(self, name: str, length: int) -> None:
        """A uint8[] as the last field; what comes before its first byte is the prefix."""
        self._number("I", length)
        self._vector["prefix_size"] = len(self._bytes)
        self._bytes += bytes(index % 251 for index in range(length))
        self._fields[name] = {"pattern": PATTERN, "length": length}
        self._pattern = [self._fields[name]]

    def few_bytes(self, name: str, length: int) -> None:
        """A uint8[] before other fields."""
        self._number("I", length)
        self._bytes += bytes(index % 251 for index in range(length))
        self._fields[name] = {"pattern": PATTERN, "length": length}

    @contextmanager
    def nested(self, name: str) -> Iterator[None]:
        """The fields written inside are those of the message in field `name`."""
        outer = self._fields
        outer[name] = self._fields = {}
        yield
        self._fields = outer

    def message_sequence[T](
        self, name: str, items: Sequence[T], write: Callable[[T], None]
    ) -> None:
        """One message per item, whose fields are those that `write` writes."""
        outer = self._fields
        self._number("I", len(items))
        outer[name] = []
        for item in items:
            self._fields = {}
            outer[name].append(self._fields)
            write(item)
        self._fields = outer

    def _float32(self, value: float) -> None:
        exact = struct.unpack("<f", struct.pack("<f", value))[0]
        assert exact == value or math.isnan(value), f"{value} is not a float32"
        self._number("f", value)

    def _number(self, code: str, value: float) -> None:
        size = struct.calcsize(f"<{code}")
        while (len(self._bytes) - len(ENCAPSULATION)) % size != 0:
            self._bytes.append(0)
        self._bytes += struct.pack(f"<{code}", value)


def json_float(value: float) -> float | str:
    """JSON has no number for these three."""
    if math.isnan(value):
        return "NaN"
    if math.isinf(value):
        return "Infinity" if value > 0 else "-Infinity"
    return value

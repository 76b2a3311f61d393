"""Describes a message type by its hash, and by its layout: the order of its values in CDR.

Two types with equal layouts read each other's bytes, whatever the names of their fields are. The
headset derives the same text from its classes; Layout.kt has the grammar.
"""

from __future__ import annotations

import functools
import importlib
import json
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from rosidl_parser.definition import (
    AbstractNestedType,
    AbstractString,
    AbstractType,
    AbstractWString,
    Array,
    BasicType,
    NamespacedType,
)

from ..printable import printable
from ..table.stream_table import MESSAGE_TYPE, SERVICE_TYPE
from ..topics.message_types import message_class, service_class
from ..wire.frame import CDR_ENCAPSULATION

_MOST_CHARACTERS = 150
_NUMBERS = {
    "boolean": "b",
    "float": "f",
    "double": "d",
    **dict.fromkeys(("char", "octet", "int8", "uint8"), "1"),
    **dict.fromkeys(("int16", "uint16"), "2"),
    **dict.fromkeys(("int32", "uint32"), "4"),
    **dict.fromkeys(("int64", "uint64"), "8"),
}


class DifferentError(ValueError):
    """The app means other bytes than this receiver."""


@dataclass(frozen=True)
class Described:
    """An installed type; `hash` is empty where its package was installed without descriptions."""

    type: str
    hash: str
    layout: str

    @property
    def is_large(self) -> bool:
        """True if a message may be long: it has a sequence of bytes or of messages."""
        return _has_large(_parts(self.layout))

    def compare(self, hash: str | None, layout: str | None) -> Literal["hash", "layout", "no"]:
        """Returns by what the app's type was found to be this one.

        Raises:
            DifferentError: it is another one.
        """
        if hash and self.hash and hash != self.hash:
            raise self._different(hash, self.hash)
        if layout and layout != self.layout:
            raise self._different(layout, self.layout)
        if hash and self.hash:
            return "hash"
        return "layout" if layout else "no"

    def _different(self, found: str, own: str) -> DifferentError:
        found, own = printable(found, _MOST_CHARACTERS), printable(own, _MOST_CHARACTERS)
        return DifferentError(f"the app's {self.type} is {found}, this receiver's is {own}")


@functools.cache
def described(type: str) -> Described:
    """Returns what is installed of a message type.

    Raises:
        ImportError: as message_class(), or it is no name of a type.
    """
    if not MESSAGE_TYPE.fullmatch(type):  # of a peer: to look for `a.b` would import `a`
        raise ImportError("expected PACKAGE/msg/NAME")
    made = message_class(type)
    return Described(type, _hash(type), layout(made))


@functools.cache
def described_service(type: str) -> Described:
    """Returns what is installed of a type of services: its layout has two parts, around `>`.

    Raises:
        ImportError: as service_class(), or it is no name of a type.
    """
    if not SERVICE_TYPE.fullmatch(type):
        raise ImportError("expected PACKAGE/srv/NAME")
    made = service_class(type)
    parts = layout(made.Request), layout(made.Response)
    return Described(type, _hash(type), ">".join(parts))


def _hash(type: str) -> str:
    package, _, rest = type.partition("/")
    spec = find_spec(package)
    assert spec is not None
    assert spec.origin is not None
    # PREFIX/lib/pythonX.Y/site-packages/PACKAGE/__init__.py
    file = Path(spec.origin).parents[4] / "share" / package / f"{rest}.json"
    hashes = json.loads(file.read_text("utf-8"))["type_hashes"] if file.is_file() else ()
    return "".join(it["hash_string"] for it in hashes if it["type_name"] == type)


def layout(message: Any) -> str:
    """Returns the layout of a message class that rosidl made, such as `[44ssddddddd]` of TFMessage.

    Raises:
        ValueError: a field has a type that no .msg file can have.
    """
    # ROS sends one byte for a message without fields.
    return "".join(_part(field) for field in message.SLOT_TYPES) or "1"


def _part(field: AbstractType) -> str:
    match field:
        case BasicType() if field.typename in _NUMBERS:
            return _NUMBERS[field.typename]
        case AbstractString():
            return "s"
        case AbstractWString():
            return "w"
        case Array():
            return f"({_part(field.value_type)}*{field.size})"
        case AbstractNestedType():
            return f"[{_part(field.value_type)}]"
        case NamespacedType():
            module = importlib.import_module(".".join(field.namespaces))
            return layout(getattr(module, field.name))
    raise ValueError(f"expected a type that .msg files can have, found {field}")


# The kinds of encapsulation that are not read, from the table of DDS-XTypes 1.3, 7.6.3.1.2.
_UNREAD = {2: "PL_CDR", 3: "PL_CDR", 6: "CDR2", 7: "CDR2"}
_UNREAD |= {8: "D_CDR2", 9: "D_CDR2", 10: "PL_CDR2", 11: "PL_CDR2"}
_BIG, _LITTLE = b"\0\0", b"\0\1"
_SIZES = {"b": 1, "1": 1, "2": 2, "4": 4, "8": 8, "f": 4, "d": 8}


def plain(payload: bytes, layout: str) -> bytes:
    """Returns a payload of this layout as plain little-endian CDR.

    Raises:
        ValueError: it has another encapsulation than CDR, or is not of this layout.
    """
    if payload.startswith(CDR_ENCAPSULATION):
        return payload
    if payload.startswith(_LITTLE):  # with options, which say how long the padding at the end is
        return CDR_ENCAPSULATION + payload[4:]
    if payload.startswith(_BIG):
        return _Walk(payload[4:], "big").message(layout)
    kind = int.from_bytes(payload[:2])
    name = _UNREAD.get(kind, "an unknown encapsulation")
    raise ValueError(f"its publisher writes {name} (0x{kind:04x}), and this receiver reads CDR")


def exact(payload: bytes, layout: str) -> bytes:
    """Returns a payload of this layout as plain() does, without bytes that mean nothing.

    Padding becomes zeros, and what is behind the message is cut off: rclpy leaves there whatever
    its memory held.

    Raises:
        ValueError: as plain(), or the message ends too early.
    """
    return _Walk(plain(payload, layout)[4:], "little").message(layout)


type _Part = str | tuple[list["_Part"], int | None]


@functools.cache
def _parts(layout: str) -> list[_Part]:
    """Returns the elements of a layout; one with a count is an array, with None a sequence."""
    parts, rest = _until_end(layout)
    assert not rest
    return parts


def _until_end(text: str) -> tuple[list[_Part], str]:
    parts: list[_Part] = []
    while text and text[0] not in "]*":
        part, text = text[0], text[1:]
        if part == "[":
            inner, text = _until_end(text)
            parts.append((inner, None))
            text = text[1:]
        elif part == "(":
            inner, text = _until_end(text)
            count, _, text = text[1:].partition(")")
            parts.append((inner, int(count)))
        else:
            parts.append(part)
    return parts, text


def _has_large(parts: list[_Part]) -> bool:
    for part in parts:
        if isinstance(part, tuple):
            inner, count = part
            if count is None and (len(inner) > 1 or inner == ["1"]):
                return True
            if _has_large(inner):
                return True
    return False


class _Walk:
    """Copies a message field by field, as little-endian numbers."""

    def __init__(self, data: bytes, order: Literal["little", "big"]) -> None:
        self._data, self._order = data, order
        self._out, self._at = bytearray(len(data)), 0

    def message(self, layout: str) -> bytes:
        self._fields(_parts(layout))
        return CDR_ENCAPSULATION + bytes(self._out[: self._at])

    def _fields(self, parts: list[_Part]) -> None:
        for part in parts:
            if part == "s":
                self._copy(self._count())
            elif part == "w":
                self._numbers(4, self._count())
            elif isinstance(part, str):
                self._numbers(_SIZES[part], 1)
            else:
                inner, count = part
                self._repeat(inner, self._count() if count is None else count)

    def _repeat(self, parts: list[_Part], count: int) -> None:
        if len(parts) == 1 and (size := _SIZES.get(str(parts[0]))):
            self._numbers(size, count)
            return
        for _ in range(count):
            self._fields(parts)

    def _count(self) -> int:
        self._numbers(4, 1)
        return int.from_bytes(self._data[self._at - 4 : self._at], self._order)

    def _copy(self, length: int) -> None:
        begin = self._take(length)
        self._out[begin : self._at] = self._data[begin : self._at]

    def _numbers(self, size: int, count: int) -> None:
        if count == 0:  # nothing is aligned for nothing
            return
        self._at += -self._at % size
        if self._order == "little":
            self._copy(size * count)
            return
        begin = self._take(size * count)
        for byte in range(size):
            other = begin + size - 1 - byte
            self._out[begin + byte : self._at : size] = self._data[other : self._at : size]

    def _take(self, length: int) -> int:
        begin, self._at = self._at, self._at + length
        if self._at > len(self._data):
            raise ValueError(f"it ends before its byte {self._at}")
        return begin

"""Messages of rclpy's classes with random values, and the CDR that they must be."""

import importlib
import json
import random
import struct
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from rosidl_parser.definition import (
    AbstractNestedType,
    AbstractSequence,
    AbstractString,
    AbstractWString,
    Array,
    BasicType,
    NamespacedType,
)

ENCAPSULATION = bytes([0x00, 0x01, 0x00, 0x00])
# The code of struct.
CODES = {
    "boolean": "?",
    "octet": "c",
    "float": "f",
    "double": "d",
    **{f"int{8 << i}": "bhiq"[i] for i in range(4)},
    **{f"uint{8 << i}": "BHIQ"[i] for i in range(4)},
}


@cache
def installed() -> dict[str, tuple[Any, dict[str, Any], Path]]:
    """The class, description and definition of each message, request and response."""
    roots = (
        root / "share" for root in Path(str(importlib.import_module("std_msgs").__file__)).parents
    )
    share = next(share for share in roots if (share / "std_msgs").is_dir())
    files = sorted([*share.glob("*/msg/*.json"), *share.glob("*/srv/*.json")])
    return {type: found for file in files for type, found in _of(file)}


def _of(file: Path) -> Iterator[tuple[str, tuple[Any, dict[str, Any], Path]]]:
    package, kind, name = *file.parts[-3:-1], file.stem
    description = json.loads(file.read_text("utf-8"))["type_description_msg"]
    module = importlib.import_module(f"{package}.{kind}")
    for part in ("",) if kind == "msg" else ("_Request", "_Response"):
        message_class = getattr(module, name + part)
        yield (
            f"{package}/{kind}/{name}{part}",
            (message_class, description, file.with_suffix(f".{kind}")),
        )


def fields(message: Any) -> Iterator[tuple[str, Any]]:
    yield from zip(message.get_fields_and_field_types(), message.SLOT_TYPES, strict=True)


class Writer:
    """CDR as it must be, with `padding` from chance where it is not 0."""

    def __init__(self, padding: random.Random | None) -> None:
        self.data = bytearray()
        self._padding = padding

    def message(self, message: Any) -> None:
        for name, type in fields(message):
            self._value(getattr(message, name), type)
        if not message.SLOT_TYPES:
            self._pad(1)

    def _value(self, value: Any, type: Any) -> None:
        match type:
            case BasicType():
                self._number(CODES[type.typename], value)
            case AbstractString():
                text = value.encode() + b"\0"
                self._number("I", len(text))
                self.data += text
            case AbstractWString():
                units = value.encode("utf-16-le")
                self._number("I", len(units) // 2)
                for unit in struct.unpack(f"<{len(units) // 2}H", units):
                    self._number("I", unit)
            case AbstractNestedType():
                if isinstance(type, AbstractSequence):
                    self._number("I", len(value))
                for element in value:
                    self._value(element, type.value_type)
            case NamespacedType():
                self.message(value)
            case _:
                raise AssertionError(type)

    def _number(self, code: str, value: Any) -> None:
        data = struct.pack(f"<{code}", value)
        self._pad(-len(self.data) % len(data))
        self.data += data

    def _pad(self, size: int) -> None:
        self.data += self._padding.randbytes(size) if self._padding else bytes(size)


def cdr(message: Any, padding: random.Random | None = None) -> bytes:
    writer = Writer(padding)
    writer.message(message)
    return ENCAPSULATION + bytes(writer.data)


def some(message: Any, chance: random.Random) -> Any:
    return message(**{name: some_value(type, chance) for name, type in fields(message)})


def some_value(type: Any, chance: random.Random) -> Any:
    match type:
        case BasicType():
            return some_number(CODES[type.typename], chance)
        case AbstractString() | AbstractWString():
            most = type.maximum_size if type.has_maximum_size() else 99
            letters = "aZ/_\n" if type.has_maximum_size() else "aZ/\nß€頭😀"
            return "".join(chance.choices(letters, k=chance.randrange(min(most, 5) + 1)))
        case Array():
            return [some_value(type.value_type, chance) for _ in range(type.size)]
        case AbstractSequence():
            most = type.maximum_size if type.has_maximum_size() else 99
            length = chance.randrange(min(most, 4) + 1)
            return [some_value(type.value_type, chance) for _ in range(length)]
        case NamespacedType():
            return some(
                getattr(importlib.import_module(".".join(type.namespaces)), type.name), chance
            )
    raise AssertionError(type)


def some_number(code: str, chance: random.Random) -> Any:
    if code == "?":
        return chance.random() < 0.5
    if code in "fd":
        exact = struct.unpack("<f", struct.pack("<f", chance.uniform(-1e30, 1e30)))[0]
        return chance.choice([0.0, -0.0, 1.5, float("inf"), exact])
    size = struct.calcsize(f"<{code}")
    data = chance.choice([chance.randbytes(size), bytes(size), b"\xff" * size])
    return struct.unpack(f"<{code}", data)[0]

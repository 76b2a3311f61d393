"""Kotlin and four other programs read what each of them writes, for every installed type of ROS.

Kotlin knows the types by the descriptions that rosidl installs, and its own by their classes.
"""

import importlib
import json
import random
import struct
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from cyclonedds import idl
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import get_types_from_msg
from rosidl_parser.definition import (
    AbstractNestedType,
    AbstractSequence,
    AbstractString,
    AbstractWString,
    Array,
    BasicType,
    BoundedString,
    NamespacedType,
    UnboundedSequence,
    UnboundedString,
    UnboundedWString,
)

from message_definitions import typestore
from ml2_receiver.ros.layout import layout

types: Any = idl.types  # whose classes are generic for the program, not for mypy
LIBRARY = Path(__file__).parents[2] / "ml2-sensors-aar"
ENCAPSULATION = bytes([0x00, 0x01, 0x00, 0x00])
# The code of struct and the type of Cyclone DDS.
NUMBERS = {
    "boolean": ("?", bool),
    "octet": ("c", types.uint8),
    "float": ("f", types.float32),
    "double": ("d", types.float64),
    **{f"int{8 << i}": ("bhiq"[i], getattr(types, f"int{8 << i}")) for i in range(4)},
    **{f"uint{8 << i}": ("BHIQ"[i], getattr(types, f"uint{8 << i}")) for i in range(4)},
}
OF_EACH_TYPE = 12


@dataclass
class Case:
    """A message: as it must be written, and as others write it."""

    type: str
    expected: bytes
    written: dict[str, bytes]


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
                self._number(NUMBERS[type.typename][0], value)
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
            return some_number(NUMBERS[type.typename][0], chance)
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


class Cyclone:
    """Messages as Cyclone DDS reads and writes them."""

    def __init__(self) -> None:
        self._structs: dict[Any, Any] = {}

    def struct_of(self, message: Any) -> Any:
        """None for a type that it does not know: it has no wstring."""
        if message not in self._structs:
            members = {name: self._member(type) for name, type in fields(message)}
            known = None not in members.values()
            self._structs[message] = known and idl.make_idl_struct(
                message.__name__, message.__name__, members or {"nothing": types.uint8}
            )
        return self._structs[message] or None

    def _member(self, type: Any) -> Any:
        match type:
            case BasicType():
                return NUMBERS[type.typename][1]
            case AbstractString():
                return types.bounded_str[type.maximum_size] if type.has_maximum_size() else str
            case Array():
                return (inner := self._member(type.value_type)) and types.array[inner, type.size]
            case AbstractSequence():
                return (inner := self._member(type.value_type)) and types.sequence[inner]
            case NamespacedType():
                module = importlib.import_module(".".join(type.namespaces))
                return self.struct_of(getattr(module, type.name))
        return None


CYCLONE = Cyclone()


@cache
def rosbags() -> Any:
    store = typestore()
    for type, (_, _, definition) in installed().items():
        if "/msg/" in type and type not in store.fielddefs:
            store.register(get_types_from_msg(definition.read_text("utf-8"), type))
    return store


def rosbags_knows(type: str) -> bool:
    return type in rosbags().fielddefs and "w" not in layout(installed()[type][0])


@cache
def cases() -> list[Case]:
    return [case for type in installed() for case in _cases(type)]


def _cases(type: str) -> Iterator[Case]:
    chance = random.Random(type)
    message_class = installed()[type][0]
    for _ in range(OF_EACH_TYPE):
        message = some(message_class, chance)
        expected = cdr(message)
        written = {
            "rclpy": serialize_message(message),
            "dirty": cdr(message, chance) + chance.randbytes(chance.randrange(9)),
        }
        if rosbags_knows(type):
            read = rosbags().deserialize_cdr(expected, type)
            written["rosbags"] = bytes(rosbags().serialize_cdr(read, type))
        if struct_of := CYCLONE.struct_of(message_class):
            written["cyclonedds"] = struct_of.deserialize(expected).serialize(use_version_2=False)
        yield Case(type, expected, written)


@pytest.fixture(scope="module")
def kotlin(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The layouts that the Kotlin library derives, and its answer to each written message."""
    folder = tmp_path_factory.mktemp("exchange")
    written = [(case.type, data) for case in cases() for data in case.written.values()]
    asked = {
        "types": {type: description for type, (_, description, _) in installed().items()},
        "messages": [{"type": type, "bytes": data.hex()} for type, data in written],
    }
    (folder / "asked.json").write_text(json.dumps(asked), "utf-8")
    parts = ["target/test-classes", "target/classes", "simulator/target/lib/*"]
    classes = ":".join(str(LIBRARY / part) for part in parts)
    program = "dev.ml2sensors.conformance.CdrExchange"
    files = [folder / "asked.json", folder / "answer.json"]
    subprocess.run(["java", "-cp", classes, program, *files], check=True)
    answer: dict[str, Any] = json.loads((folder / "answer.json").read_text("utf-8"))
    return answer


def test_layouts_are_the_same_in_both_languages(kotlin: dict[str, Any]) -> None:
    assert {"test_msgs/msg/WStrings", "test_msgs/srv/Empty_Request"} < installed().keys()
    assert kotlin["layouts"] == {type: layout(it) for type, (it, _, _) in installed().items()}


def test_types_of_one_layout_read_each_others_bytes() -> None:
    """But a message without fields ignores its byte, and a bound refuses what is longer."""
    alike: dict[str, set[str]] = {}
    for type, (message_class, _, _) in installed().items():
        if message_class.SLOT_TYPES and "/Bounded" not in type:
            alike.setdefault(layout(message_class), set()).add(type)
    assert {"geometry_msgs/msg/Point", "geometry_msgs/msg/Vector3"} <= alike["ddd"]
    for case in cases():
        for other in alike.get(layout(installed()[case.type][0]), ()):
            read = deserialize_message(case.expected, installed()[other][0])
            assert cdr(read) == case.expected, f"{case.type} as {other}"


SCAN = (
    BasicType("int32"),
    UnboundedString(),
    Array(BasicType("double"), 9),
    UnboundedSequence(BasicType("uint8")),
    NamespacedType(["std_msgs", "msg"], "Header"),
)


def layout_of(*fields: Any) -> str:
    return layout(SimpleNamespace(SLOT_TYPES=fields))


def test_a_type_has_another_layout_if_its_bytes_would_be_misread() -> None:
    misread = [
        (0, BasicType("int64")),
        (0, BasicType("float")),
        (0, UnboundedString()),
        (1, UnboundedWString()),
        (1, UnboundedSequence(BasicType("uint8"))),
        (2, Array(BasicType("double"), 8)),
        (2, Array(BasicType("float"), 9)),
        (2, UnboundedSequence(BasicType("double"))),
        (3, UnboundedSequence(BasicType("boolean"))),
        (3, Array(BasicType("uint8"), 9)),
        (4, NamespacedType(["builtin_interfaces", "msg"], "Time")),
    ]
    layouts = {layout_of(*SCAN), layout_of(*SCAN[::-1])}
    for index, type in misread:
        layouts.add(layout_of(*SCAN[:index], type, *SCAN[index + 1 :]))
    assert len(layouts) == len(misread) + 2
    # Bounds and signs change no byte.
    same = layout_of(BasicType("uint32"), BoundedString(5), *SCAN[2:])
    assert same == layout_of(*SCAN) == "4s(d*9)[1]44s"
    # The bracket says where an array ends.
    three, four = Array(BasicType("uint8"), 3), BasicType("uint32")
    assert layout_of(three, four) != layout_of(Array(BasicType("uint8"), 34))


@pytest.mark.parametrize("type", ["wchar", "long double"])
def test_a_type_that_messages_cannot_have_has_no_layout(type: str) -> None:
    with pytest.raises(ValueError, match=r"expected a type that \.msg files can have, found"):
        layout_of(BasicType(type))


def test_kotlin_reads_what_others_write(kotlin: dict[str, Any]) -> None:
    answers = iter(kotlin["messages"])
    for case in cases():
        for writer in case.written:
            assert next(answers) == case.expected.hex(), f"{case.type} of {writer}"
    assert next(answers, None) is None


def test_others_read_what_kotlin_writes() -> None:
    """Which is `expected`, by the test above."""
    readers = dict.fromkeys(("rclpy", "rosbags", "cyclonedds"), 0)
    for case in cases():
        message_class = installed()[case.type][0]
        assert cdr(deserialize_message(case.expected, message_class)) == case.expected, case.type
        for writer in case.written.keys() & readers.keys():
            readers[writer] += 1
            written = case.written[writer]
            assert written[4 : len(case.expected)] == case.expected[4:] or writer == "rclpy", case
    assert all(count > 1000 for count in readers.values()), readers

"""Kotlin and four other programs read what each of them writes, for every installed type of ROS.

Kotlin knows the types by the descriptions that rosidl installs, and its own by their classes.
"""

import importlib
import json
import os
import random
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
    AbstractSequence,
    AbstractString,
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
from rclpy_messages import cdr, fields, installed, some

types: Any = idl.types  # whose classes are generic for the program, not for mypy
LIBRARY = Path(__file__).parents[2] / "ml2-sensors-aar"
# The types of Cyclone DDS.
NUMBERS = {
    "boolean": bool,
    "octet": types.uint8,
    "float": types.float32,
    "double": types.float64,
    **{
        f"{sign}int{8 << i}": getattr(types, f"{sign}int{8 << i}")
        for i in range(4)
        for sign in ("", "u")
    },
}
OF_EACH_TYPE = 12


@dataclass
class Case:
    """A message: as it must be written, and as others write it."""

    type: str
    expected: bytes
    written: dict[str, bytes]


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
                return NUMBERS[type.typename]
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
    environment = os.environ | {"LC_ALL": "C.UTF-8"}  # Java takes the encoding of paths from it
    subprocess.run(["java", "-cp", classes, program, *files], env=environment, check=True)
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
    """Kotlin writes `expected`, by the test above."""
    readers = dict.fromkeys(("rclpy", "rosbags", "cyclonedds"), 0)
    for case in cases():
        message_class = installed()[case.type][0]
        assert cdr(deserialize_message(case.expected, message_class)) == case.expected, case.type
        for writer in case.written.keys() & readers.keys():
            readers[writer] += 1
            written = case.written[writer]
            assert written[4 : len(case.expected)] == case.expected[4:] or writer == "rclpy", case
    assert all(count > 1000 for count in readers.values()), readers

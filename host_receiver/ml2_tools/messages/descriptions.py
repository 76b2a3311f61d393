"""Message types as rosidl describes them in share/PACKAGE/msg/TYPE.json, with their constants."""

import ast
import json
import os
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

from mcap_ros2._vendor.rosidl_adapter.parser import parse_message_string

from ..errors import MessagesError

# The numbers of type_description_interfaces/msg/FieldType; 48 more for each further shape.
_KINDS = {
    1: "message", 2: "int8", 3: "uint8", 4: "int16", 5: "uint16", 6: "int32", 7: "uint32",
    8: "int64", 9: "uint64", 10: "float32", 11: "float64", 13: "uint8", 15: "bool", 16: "uint8",
    17: "string", 18: "wstring", 21: "string", 22: "wstring",
}  # fmt: skip
_SHAPES: tuple[Literal["one", "array", "sequence"], ...] = ("one", "array", "sequence", "sequence")
_SIZES = {"bool": 1, "float32": 4, "float64": 8, "string": 5, "wstring": 4}
# The names of constants' types in .msg files that descriptions call otherwise.
_ALIASES = {"byte": "uint8", "char": "uint8"}
_PARTS = re.compile(r"^---\s*$", re.MULTILINE)
_FILLER = "structure_needs_at_least_one_member"


@dataclass(frozen=True)
class Field:
    """A field of a message.

    `kind` is that of .msg files without `byte` and `char`, or `message`, whose type is `nested`.
    `capacity` is the length of an array, or the bound of a sequence; `most_bytes` is the bound of a
    text. Both are None where there is none. `default` is None, a value, or a tuple of values.
    """

    name: str
    kind: str
    nested: str
    shape: Literal["one", "array", "sequence"]
    capacity: int | None
    most_bytes: int | None
    default: Any


@dataclass(frozen=True)
class MessageType:
    """A message, request or response; `constants` are name, kind and value."""

    name: str
    hash: str
    fields: tuple[Field, ...]
    constants: tuple[tuple[str, str, Any], ...]

    @property
    def package(self) -> str:
        return self.name.partition("/")[0]

    @property
    def class_name(self) -> str:
        """Returns `ImuMsg` for sensor_msgs/msg/Imu, `TriggerRequest` for a Trigger_Request."""
        _, kind, name = self.name.split("/")
        return name.replace("_", "") if kind == "srv" else f"{name}Msg"

    @property
    def is_stamped(self) -> bool:
        return self.fields[:1] == (
            Field("header", "message", "std_msgs/msg/Header", "one", None, None, None),
        )

    def least_size(self) -> int:
        """Returns the fewest bytes that a message of this type takes, without padding."""
        return max(1, sum(_least_size(it) for it in self.fields))


def _least_size(field: Field) -> int:
    if field.shape == "sequence":
        return 4
    size = (
        message_type(field.nested).least_size()
        if field.kind == "message"
        else _SIZES.get(field.kind) or int(field.kind.removeprefix("u").removeprefix("int")) // 8
    )
    return size * (field.capacity or 0 if field.shape == "array" else 1)


def types_of(packages: Iterable[str]) -> list[MessageType]:
    """Returns the messages, requests and responses of the packages.

    Raises:
        MessagesError: A package or a description is not there, or has what messages cannot have.
    """
    return [message_type(name) for package in packages for name in _names(package)]


def with_nested(types: Iterable[MessageType]) -> list[MessageType]:
    """Returns the types and all that their fields have, sorted by name."""
    found: dict[str, MessageType] = {}
    left = list(types)
    while left:
        type = left.pop()
        if type.name not in found:
            found[type.name] = type
            left += [message_type(it.nested) for it in type.fields if it.kind == "message"]
    return sorted(found.values(), key=lambda it: it.name)


def share(package: str) -> Path:
    """Returns the folder of a package with descriptions: of a sourced workspace, or of the wheels.

    Raises:
        MessagesError: There is none.
    """
    prefixes = [*os.environ.get("AMENT_PREFIX_PATH", "").split(":"), sys.prefix]
    folders = [Path(it) / "share" / package for it in prefixes if it]
    for folder in folders:
        if any(folder.glob("*/*.json")):
            return folder
    where = ", ".join(str(it.parent) for it in folders)
    raise MessagesError(
        f"expected a package {package} with descriptions of messages, found none in {where}: "
        f"install it, or source its workspace. Packages have descriptions since ROS 2 Jazzy."
    )


def _names(package: str) -> Iterator[str]:
    for file in sorted(share(package).glob("*/*.json")):
        if file.parent.name == "msg":
            yield f"{package}/msg/{file.stem}"
        elif file.parent.name == "srv":
            yield from (f"{package}/srv/{file.stem}_{part}" for part in ("Request", "Response"))


@cache
def message_type(name: str) -> MessageType:
    """Returns a type by its name, such as sensor_msgs/msg/Imu or std_srvs/srv/Trigger_Request.

    Raises:
        MessagesError: as types_of().
    """
    package, kind, stem = name.split("/")
    part = stem.rpartition("_")[2] if kind == "srv" else ""
    file = share(package) / kind / f"{stem.removesuffix(f'_{part}')}.json"
    try:
        whole = json.loads(file.read_text("utf-8"))
        hashes = {it["type_name"]: it["hash_string"] for it in whole["type_hashes"]}
        described = whole["type_description_msg"]
        all_types = [described["type_description"], *described["referenced_type_descriptions"]]
        fields = next(it["fields"] for it in all_types if it["type_name"] == name)
        return MessageType(
            name,
            hashes[name],
            tuple(_field(name, it) for it in fields if it["name"] != _FILLER),
            tuple(_constants(file.with_suffix(f".{kind}"), part)),
        )
    except (OSError, ValueError, LookupError, TypeError, StopIteration) as error:
        raise MessagesError(f"{file}: expected a description of {name}, found {error!r}") from error


def _field(type: str, described: dict[str, Any]) -> Field:
    name, field = described["name"], described["type"]
    shape, number = divmod(field["type_id"] - 1, 48)
    kind = _KINDS.get(number + 1)
    if kind is None or shape not in range(4):
        raise MessagesError(
            f"{type}: expected a kind that .msg files can have, found {field['type_id']} of {name}"
        )
    text = described["default_value"]
    has_text = kind in ("string", "wstring") and shape == 0
    return Field(
        name,
        kind,
        field["nested_type_name"],
        _SHAPES[shape],
        field["capacity"] if shape in (1, 2) else None,
        field["string_capacity"] or None,
        None if text == "" else text if has_text else ast.literal_eval(text),
    )


def _constants(definition: Path, part: str) -> Iterator[tuple[str, str, Any]]:
    """Yields the constants, which descriptions do not have; none for a type written in IDL."""
    if not definition.is_file():
        return
    text = _PARTS.split(definition.read_text("utf-8"))[part == "Response"]
    for it in parse_message_string("none", "None", text).constants:
        yield it.name, _ALIASES.get(it.type, it.type), it.value

"""What a message type is: its hash, and its layout, which is how CDR walks through it, as text.

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

from ..topics.message_types import message_class

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
        return DifferentError(f"the app's {self.type} is {found}, this receiver's is {own}")


@functools.cache
def described(type: str) -> Described:
    """Returns what is installed.

    Raises:
        ImportError: as message_class().
    """
    made = message_class(type)
    package, _, rest = type.partition("/")
    spec = find_spec(package)
    assert spec is not None
    assert spec.origin is not None
    # PREFIX/lib/pythonX.Y/site-packages/PACKAGE/__init__.py
    file = Path(spec.origin).parents[4] / "share" / package / f"{rest}.json"
    hashes = json.loads(file.read_text("utf-8"))["type_hashes"] if file.is_file() else ()
    found = [it["hash_string"] for it in hashes if it["type_name"] == type]
    return Described(type, "".join(found), layout(made))


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
            return f"({_part(field.value_type)})*{field.size}"
        case AbstractNestedType():
            return f"[{_part(field.value_type)}]"
        case NamespacedType():
            module = importlib.import_module(".".join(field.namespaces))
            return layout(getattr(module, field.name))
    raise ValueError(f"expected a type that .msg files can have, found {field}")

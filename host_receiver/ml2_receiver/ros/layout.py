"""The layout of a message type: how CDR walks through it, as text.

Two types with equal layouts read each other's bytes, whatever the names of their fields are. The
headset derives the same text from its classes; Layout.kt has the grammar.
"""

from __future__ import annotations

import importlib
from typing import Any

from rosidl_parser.definition import (
    AbstractNestedType,
    AbstractString,
    AbstractType,
    AbstractWString,
    Array,
    BasicType,
    NamespacedType,
)

_NUMBERS = {
    "boolean": "b",
    "float": "f",
    "double": "d",
    **dict.fromkeys(("char", "octet", "int8", "uint8"), "1"),
    **dict.fromkeys(("int16", "uint16"), "2"),
    **dict.fromkeys(("int32", "uint32"), "4"),
    **dict.fromkeys(("int64", "uint64"), "8"),
}


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

"""Kotlin classes of messages for the Android library, whose format `Cdr` writes and reads them."""

from collections.abc import Iterable, Iterator
from typing import Any

from ml2_receiver.json_text import json_text

from .descriptions import Field, MessageType, message_type

_TYPES = {
    "bool": "Boolean", "int8": "Byte", "uint8": "UByte", "int16": "Short", "uint16": "UShort",
    "int32": "Int", "uint32": "UInt", "int64": "Long", "uint64": "ULong", "float32": "Float",
    "float64": "Double", "string": "String", "wstring": "String",
}  # fmt: skip
# Unsigned arrays of Kotlin are experimental, those of bool have no block in CDR.
_ARRAYS = {
    "int8": "ByteArray", "int16": "ShortArray", "int32": "IntArray", "int64": "LongArray",
    "float32": "FloatArray", "float64": "DoubleArray",
}  # fmt: skip
_KEYWORDS = """
as break class continue do else false for fun if in interface is null object package return super
this throw true try typealias typeof val var when while
"""


def source(types: Iterable[MessageType]) -> str:
    """Returns the classes of types of one package, below the line that says where they are from."""
    types = list(types)
    classes = "\n".join("\n".join([*_class(it), ""]) for it in types)
    return f"""@file:Suppress("ktlint")

package {_package(types[0])}

import dev.ml2sensors.cdr.ByteSequenceSerializer
import dev.ml2sensors.cdr.FixedLength
import dev.ml2sensors.cdr.WideStringSerializer
import kotlinx.serialization.SerialName
import kotlinx.serialization.Serializable
import java.nio.ByteBuffer

{classes}"""


def _package(type: MessageType) -> str:
    return f"ros.{type.package}"


def _class(type: MessageType) -> Iterator[str]:
    yield f"/** {type.name} of ROS 2. */"
    yield "@Serializable"
    yield f'@SerialName("{type.name}")'
    yield f"public class {type.class_name}" + ("(" if type.fields else "")
    if type.fields:
        yield from (f"    {_property(it)}," for it in type.fields)
        yield ")"
    yield "{"
    bounds = [line for it in type.fields for line in _bounds(it)]
    if bounds:
        yield "    init {"
        yield from (f"        {it}" for it in bounds)
        yield "    }"
        yield ""
    yield "    public companion object {"
    yield "        /** The hash of the type (REP-2016). */"
    yield f'        public const val ROS_HASH: String = "{type.hash}"'
    for name, kind, value in type.constants:
        yield f"        public const val {name}: {_TYPES[kind]} = {_literal(kind, value)}"
    yield "    }"
    yield "}"


def _name(field: Field) -> str:
    return f"`{field.name}`" if field.name in _KEYWORDS.split() else field.name


def _element(field: Field) -> str:
    if field.kind == "message":
        nested = message_type(field.nested)
        return f"{_package(nested)}.{nested.class_name}"
    text = "@Serializable(with = WideStringSerializer::class) String"
    return text if field.kind == "wstring" else _TYPES[field.kind]


def _is_bytes(field: Field) -> bool:
    return field.kind == "uint8" and field.shape != "one"


def _property(field: Field) -> str:
    type, value = _element(field), _value(field)
    if _is_bytes(field):
        type = "@Serializable(with = ByteSequenceSerializer::class) ByteBuffer"
    elif field.shape != "one":
        type = _ARRAYS.get(field.kind) or f"List<{type}>"
    fixed = f"@FixedLength({field.capacity}) " if field.shape == "array" else ""
    return f"{fixed}public val {_name(field)}: {type} = {value}"


def _value(field: Field) -> str:
    """Returns the default of ROS, or else zeros and empty texts."""
    zero = {"message": f"{_element(field)}()", "bool": "false", "string": '""', "wstring": '""'}
    empty = zero.get(field.kind) or _literal(field.kind, 0)
    if field.shape == "one":
        return empty if field.default is None else _literal(field.kind, field.default)
    array = _ARRAYS.get(field.kind)
    if field.default is not None:
        literals = ", ".join(_literal(field.kind, it) for it in field.default)
        if _is_bytes(field):
            signed = ", ".join(str((it ^ 128) - 128) for it in field.default)
            return f"ByteBuffer.wrap(byteArrayOf({signed}))"
        return f"{array[0].lower() + array[1:] + 'Of' if array else 'listOf'}({literals})"
    count = field.capacity if field.shape == "array" else 0
    if _is_bytes(field):
        return f"ByteBuffer.allocate({count})"
    if array:
        return f"{array}({count})"
    return f"List({count}) {{ {empty} }}" if count else "emptyList()"


def _bounds(field: Field) -> Iterator[str]:
    name, most = _name(field), field.capacity
    if field.shape == "sequence" and most is not None:
        size = f"{name}.remaining()" if _is_bytes(field) else f"{name}.size"
        found = f'"{field.name}: expected at most {most} elements, found ${{{size}}}"'
        yield f"require({size} <= {most}) {{ {found} }}"
    if field.most_bytes is not None:
        size = "length" if field.kind == "wstring" else "encodeToByteArray().size"
        one = f"it.{size} <= {field.most_bytes}"
        found = f'"{field.name}: expected text of at most {field.most_bytes} bytes"'
        texts = f"listOf({name})" if field.shape == "one" else name
        yield f"require({texts}.all {{ {one} }}) {{ {found} }}"


def _literal(kind: str, value: Any) -> str:
    """Returns a value as Kotlin writes it."""
    match kind:
        case "bool":
            return "true" if value else "false"
        case "string" | "wstring":
            return json_text(value).replace("$", "\\$").replace("\\f", "\\u000c")
        case "float32" | "float64":
            type = _TYPES[kind]
            special = {"inf": "POSITIVE_INFINITY", "-inf": "NEGATIVE_INFINITY", "nan": "NaN"}
            text = repr(float(value))
            return f"{type}.{special[text]}" if text in special else text + "f" * (type == "Float")
        case "int64" if value == -(1 << 63):
            return "Long.MIN_VALUE"
        case _:
            return f"{int(value)}{'u' * kind.startswith('u')}"

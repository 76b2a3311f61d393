"""C# classes of messages that write and read themselves as CDR, for the Unity package."""

from collections.abc import Collection, Iterable, Iterator
from typing import Any

from ml2_receiver.json_text import json_text
from ml2_receiver.table.reader import load_table

from .descriptions import Field, MessageType, message_type, with_nested

LIBRARY = "Ml2Sensors.Messages"
# Types that scripts commonly exchange, in addition to those of the stream table.
_COMMON = """
std_msgs/Bool std_msgs/Empty std_msgs/Float32 std_msgs/Float64 std_msgs/Int32 std_msgs/Int64
geometry_msgs/PointStamped geometry_msgs/TransformStamped geometry_msgs/TwistStamped
geometry_msgs/PoseWithCovarianceStamped geometry_msgs/Vector3Stamped geometry_msgs/WrenchStamped
sensor_msgs/JointState sensor_msgs/Joy sensor_msgs/LaserScan sensor_msgs/NavSatFix
sensor_msgs/PointCloud2 sensor_msgs/Range sensor_msgs/RelativeHumidity sensor_msgs/Temperature
nav_msgs/Odometry nav_msgs/Path
"""
_SERVICES = ("std_srvs/srv/SetBool", "std_srvs/srv/Trigger")
_TYPES = {
    "bool": "bool", "int8": "sbyte", "uint8": "byte", "int16": "short", "uint16": "ushort",
    "int32": "int", "uint32": "uint", "int64": "long", "uint64": "ulong", "float32": "float",
    "float64": "double", "string": "string", "wstring": "string",
}  # fmt: skip
_KEYWORDS = """
abstract as base bool break byte case catch char checked class const continue decimal default
delegate do double else enum event explicit extern false finally fixed float for foreach goto if
implicit in int interface internal is lock long namespace new null object operator out override
params private protected public readonly ref return sbyte sealed short sizeof stackalloc static
string struct switch this throw true try typeof uint ulong unchecked unsafe ushort using virtual
void volatile while
"""


def source(types: Iterable[MessageType], library: Collection[str], namespace: str) -> str:
    """Returns the classes of types in a namespace, below the line that says where they are from.

    library: The types that the Unity package has.
    """
    classes = "\n".join("\n".join([*_class(it, library), ""]) for it in types)
    return f"""#pragma warning disable 1591 // `ros2 interface show TYPE` documents the fields.

namespace {namespace}
{{
{classes}}}
"""


def library_types() -> list[MessageType]:
    """Returns the types whose classes the Unity package has.

    Raises:
        MessagesError: as descriptions.types_of().
    """
    names = {topic.type for stream in load_table().streams.values() for topic in stream.topics}
    names |= {name.replace("/", "/msg/") for name in _COMMON.split()}
    names |= {f"{name}_{part}" for name in _SERVICES for part in ("Request", "Response")}
    return with_nested(map(message_type, sorted(names)))


def namespace_of(package: str) -> str:
    """Returns the namespace of classes that the Unity package does not have."""
    return f"{LIBRARY}.{''.join(it.capitalize() for it in package.split('_'))}"


def _class(type: MessageType, library: Collection[str]) -> Iterator[str]:
    interfaces = ["IReadable", *(["IStamped"] if type.is_stamped else [])]
    fields = [_Member(it, library) for it in type.fields]
    yield f"    /// <summary>{type.name} of ROS 2.</summary>"
    yield f"    public sealed class {type.class_name} : {', '.join(interfaces)}"
    yield "    {"
    for name, kind, value in type.constants:
        yield f"        public const {_TYPES[kind]} {name} = {_literal(kind, value)};"
    yield from (f"        public {it.declaration()}" for it in fields)
    if type.fields or type.constants:
        yield ""
    if type.is_stamped:
        yield f"        public {fields[0].type} Header => header;"
        yield ""
    yield f'        public string RosType => "{type.name}";'
    yield ""
    yield f'        public string RosHash => "{type.hash}";'
    for verb, lines in (("Write(CdrWriter", "write"), ("Read(CdrReader", "read")):
        calls = [getattr(it, lines)() for it in fields]
        yield ""
        yield f"        public void {verb} cdr)"
        yield "        {"
        yield from (f"            cdr.{it};" for it in calls or [f"{lines.capitalize()}Empty()"])
        yield "        }"
    yield "    }"


class _Member:
    """A field in C#."""

    def __init__(self, field: Field, library: Collection[str]) -> None:
        self._field = field
        self._name = f"@{field.name}" if field.name in _KEYWORDS.split() else field.name
        self._element = _TYPES.get(field.kind) or _reference(message_type(field.nested), library)
        self.type = self._element if field.shape == "one" else f"{self._element}[]"

    def declaration(self) -> str:
        value = self._value()
        return f"{self.type} {self._name}{f' = {value}' if value else ''};"

    def _value(self) -> str:
        field, element = self._field, self._element
        if field.default is not None and field.shape == "one":
            return _literal(field.kind, field.default)
        if field.default is not None:
            values = ", ".join(_literal(field.kind, it) for it in field.default)
            return f"{{ {values} }}" if values else f"new {element}[0]"
        empty = {"message": f"new {element}()", "string": '""', "wstring": '""'}.get(field.kind, "")
        if field.shape == "sequence":
            return f"new {element}[0]"
        if field.shape == "one":
            return empty
        if empty:
            return f"System.Array.ConvertAll(new byte[{field.capacity}], _ => {empty})"
        return f"new {element}[{field.capacity}]"

    def write(self) -> str:
        return self._call("Write", self._name)

    def read(self) -> str:
        least = ""
        if self._field.kind == "message" and self._field.shape == "sequence":
            least = f", {message_type(self._field.nested).least_size()}"
        return self._call("Read", f'ref {self._name}, "{self._field.name}"{least}')

    def _call(self, verb: str, arguments: str) -> str:
        """Returns, of cdr's methods, the one for the field's kind and shape."""
        field = self._field
        if field.kind == "message":
            method = {"one": "Message", "array": "Messages", "sequence": "Sequence"}[field.shape]
        else:
            method = "Fixed" if field.shape == "array" else ""
            method += "Wide" if field.kind == "wstring" else ""
            method += "Texts" if field.kind.endswith("string") and field.shape != "one" else ""
        bounds: list[str] = []
        if field.capacity is not None:
            bounds.append(str(field.capacity))
        if field.most_bytes is not None:
            if field.shape == "sequence" and field.capacity is None:
                bounds.append("int.MaxValue")
            bounds.append(str(field.most_bytes))
        return f"{verb}{method}({', '.join([arguments, *bounds])})"


def _reference(type: MessageType, library: Collection[str]) -> str:
    namespace = LIBRARY if type.name in library else namespace_of(type.package)
    return type.class_name if type.name in library else f"global::{namespace}.{type.class_name}"


def _literal(kind: str, value: Any) -> str:
    """Returns a value as C# writes it."""
    match kind:
        case "bool":
            return "true" if value else "false"
        case "string" | "wstring":
            return json_text(value)  # whose escapes C# has, too
        case "float32" | "float64":
            type = _TYPES[kind]
            special = {"inf": "PositiveInfinity", "-inf": "NegativeInfinity", "nan": "NaN"}
            text = repr(float(value))
            return f"{type}.{special[text]}" if text in special else text + "f" * (type == "float")
        case _:
            return str(int(value))

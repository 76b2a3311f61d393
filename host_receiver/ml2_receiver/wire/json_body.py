"""Converts JSON bodies of frames to and from dataclasses, whose fields are the schema."""

import dataclasses
import functools
import json
import math
import types
from collections.abc import Mapping
from typing import Any, Literal, Self, TypeAliasType, Union, get_args, get_origin, get_type_hints

from ..errors import ErrorCode, ProtocolError

type Scalar = bool | int | float | str

_DEPTH = 16


class JsonBody:
    """The base of the frozen dataclasses that describe JSON bodies.

    A field is bool, int, float, str, a Literal of strings, another dataclass, or a list, dict or
    union of these. A key without default is required; unknown keys are ignored.
    """

    @classmethod
    def parse(cls, body: bytes | bytearray) -> Self:
        """Returns the message in a frame's body, whose size the frame parser has bounded.

        Raises:
            ProtocolError: `malformed`, naming the key, what was expected and what was found.
        """
        try:
            document = json.loads(body.decode("utf-8"), parse_constant=_no_constant)
            json.dumps(document, ensure_ascii=False).encode()  # fails on a lone surrogate
            _check_depth(_expect(dict, document, "body"))
            value: Self = _read(cls, document, "body")
        except RecursionError as error:
            message = f"{cls.__name__}: nested more than {_DEPTH} deep"
            raise ProtocolError(ErrorCode.MALFORMED, message) from error
        except ValueError as error:
            raise ProtocolError(ErrorCode.MALFORMED, f"{cls.__name__}: {error}") from error
        return value

    def to_bytes(self) -> bytes:
        """Returns the JSON object; a key that has its default None is absent."""
        return json.dumps(_plain(self), ensure_ascii=False, separators=(",", ":")).encode()


def _no_constant(name: str) -> None:
    raise ValueError(f"{name} is not JSON")


def _check_depth(document: Any) -> None:
    level = [document]
    for _ in range(_DEPTH):
        children = (value.values() if isinstance(value, dict) else value for value in level)
        level = [child for group in children for child in group if isinstance(child, dict | list)]
    if level:
        raise ValueError(f"nested more than {_DEPTH} deep")


def _read(kind: Any, value: Any, path: str) -> Any:
    if isinstance(kind, TypeAliasType):
        kind = kind.__value__
    origin, arguments = get_origin(kind), get_args(kind)
    if dataclasses.is_dataclass(kind):
        return _read_fields(kind, _expect(dict, value, path), path)
    if origin is list:
        items = enumerate(_expect(list, value, path))
        return [_read(arguments[0], item, f"{path}[{index}]") for index, item in items]
    if origin in (dict, Mapping):
        items = _expect(dict, value, path).items()
        return {
            _read(str, key, path): _read(arguments[1], item, f"{path}.{key}") for key, item in items
        }
    if origin is Literal:
        if value not in arguments:
            raise ValueError(
                f"{path}: expected one of {', '.join(arguments)}, found {_show(value)}"
            )
        return value
    if origin in (Union, types.UnionType):
        return _read_union(arguments, value, path)
    return _read_scalar(kind, value, path)


def _read_fields(kind: Any, document: dict[str, Any], path: str) -> Any:
    hints = _hints(kind)
    for field in dataclasses.fields(kind):
        if field.default is dataclasses.MISSING and field.name not in document:
            raise ValueError(f"{path}.{field.name}: missing")
    return kind(
        **{
            name: _read(hint, document[name], f"{path}.{name}")
            for name, hint in hints.items()
            if name in document
        }
    )


@functools.cache
def _hints(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind)


def _read_union(kinds: tuple[Any, ...], value: Any, path: str) -> Any:
    for kind in kinds:
        if kind is types.NoneType and value is not None:
            continue  # its error would hide what is wrong in the value
        try:
            return _read(kind, value, path)
        except ValueError as error:
            last = error
    raise last


def _read_scalar(kind: Any, value: Any, path: str) -> Any:
    if kind is float and type(value) is int:
        value = float(value) if abs(value) < 1 << 63 else math.inf
    _expect(kind, value, path)
    if kind is float and not math.isfinite(value):
        raise ValueError(f"{path}: expected a finite number")
    if kind is int and not -(1 << 63) <= value < 1 << 63:
        raise ValueError(f"{path}: expected a 64-bit integer")
    return value


def _expect(kind: Any, value: Any, path: str) -> Any:
    if type(value) is not kind:
        raise ValueError(f"{path}: expected {kind.__name__}, found {_show(value)}")
    return value


def _show(value: Any) -> str:
    """Returns a value for a message; only the type of a list or object, as it may have secrets."""
    kind = type(value).__name__
    return kind if isinstance(value, dict | list) else f"{kind} {str(value)[:40]!r}"


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value):
        fields = ((field, getattr(value, field.name)) for field in dataclasses.fields(value))
        return {
            field.name: _plain(item)
            for field, item in fields
            if item is not None or field.default is dataclasses.MISSING
        }
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


def check_text(key: str, text: str, max_length: int) -> None:
    """Raises ValueError if `text` is too long or could move a terminal's cursor."""
    if not 1 <= len(text) <= max_length or not text.isprintable():
        raise ValueError(f"{key}: expected 1 to {max_length} printable characters")

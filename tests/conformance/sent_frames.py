"""The frames that a malformed case sends, as changes of valid ones. See README.md.

`bytes_of` is what every runner does. `described` is for the generator: it finds a short description
of bytes, from which `bytes_of` makes them again.
"""

import json
import re
import struct
from collections.abc import Iterator
from typing import Any

from bodies import REQUEST
from frame_bytes import KINDS, header, json_bytes
from pieces import Piece, joined, split

Part = Piece | dict[str, Any]
# The bodies of valid frames: an object is JSON, a list is pieces.
Valid = dict[str, Any]
_HEADER_BYTES = 32
_FIELDS = ("magic", "version", "flags", "channel", "sequence", "capture", "send")
_DEFAULTS = ("M2", 1, 0, 0, 0, 0, 0)
_NAMES = {number: name for name, number in KINDS.items()}


def bytes_of(parts: list[Part], valid: Valid) -> bytes:
    return b"".join(
        _frame(part, valid) if isinstance(part, dict) and "frame" in part else joined([part])
        for part in parts
    )


def _frame(part: dict[str, Any], valid: Valid) -> bytes:
    body = _body(part, valid)
    fields = part.get("header", {})
    fields = fields | ({"magic": fields["magic"].encode()} if "magic" in fields else {})
    kind = KINDS.get(part["frame"], part["frame"])
    whole = header(kind, **({"length": len(body)} | fields)) + body
    return whole[: len(whole) - part.get("cut_bytes", 0)]


def _body(part: dict[str, Any], valid: Valid) -> bytes:
    if "body" in part:
        return joined(part["body"])
    if "json" in part:
        return text_of(part["json"])
    body = valid.get(part.get("valid", part["frame"]), [])
    if isinstance(body, list):
        return joined(body)
    for path in part.get("without", []):
        body = _changed(body, path.split("."))
    for path, value in part.get("with", {}).items():
        body = _changed(body, path.split("."), value)
    text = text_of(body)
    if "replace" in part:
        assert text.count(part["replace"].encode()) == 1, part
        text = text.replace(part["replace"].encode(), joined(part["by"]))
    return joined(part.get("before", [])) + text + joined(part.get("after", []))


def text_of(body: Any) -> bytes:
    """Compact JSON, in which the number REQUEST has no quotes."""
    return json_bytes(body).replace(f'"{REQUEST}"'.encode(), REQUEST.encode())


def _changed(body: dict[str, Any], path: list[str], *value: Any) -> dict[str, Any]:
    """`body` with the value at `path`; without that key if there is none."""
    key, *rest = path
    if rest:
        return body | {key: _changed(body[key], rest, *value)}
    if value:
        return body | {key: value[0]}
    return {other: it for other, it in body.items() if other != key}


def described(data: bytes, valid: Valid) -> list[Part]:
    parts = list(_parts(data, valid))
    assert bytes_of(parts, valid) == data, parts
    return parts


def _parts(data: bytes, valid: Valid) -> Iterator[Part]:
    while data:
        if data[:2] not in (b"M2", b"2M", b"XX"):
            yield from split(data)
            return
        head = data[:_HEADER_BYTES]
        missing = _HEADER_BYTES - len(head)
        magic, version, kind, *fields = struct.unpack("<2sBBHHIIqq", head + bytes(missing))
        flags, channel, sequence, length, capture, send = fields
        body, data = (data[_HEADER_BYTES:][:length], data[_HEADER_BYTES + length :])
        found = (magic.decode(), version, flags, channel, sequence, capture, send)
        part: dict[str, Any] = {"frame": _NAMES.get(kind, kind)}
        changed = {
            field: value
            for field, value, default in zip(_FIELDS, found, _DEFAULTS, strict=True)
            if value != default
        }
        whole = _valid_text(part["frame"], valid)
        if len(body) < length == len(whole) and whole.startswith(body):
            missing = len(whole) - len(body)
            body = whole
        if len(body) != length:
            changed["length"] = length
        part |= {"header": changed} if changed else {}
        part |= _described_body(part["frame"], body, valid)
        yield part | ({"cut_bytes": missing} if missing else {})


def _valid_text(name: str | int, valid: Valid) -> bytes:
    body = valid.get(str(name), [])
    return joined(body) if isinstance(body, list) else text_of(body)


def _described_body(name: str | int, body: bytes, valid: Valid) -> dict[str, Any]:
    """The shortest description that makes these bytes again."""
    options: list[dict[str, Any]] = [{}, {"body": split(body)}]
    value = _value(body)
    if value is not None:
        options.append({"json": value})
    for base in (it for it in valid if it == name or it.startswith(f"{name} ")):
        chosen = {"valid": base} if base != name else {}
        if isinstance(valid[base], dict):
            options += [chosen | it for it in _changes(body, value, valid[base])]
    same = [it for it in options if _body({"frame": name} | it, valid) == body]
    return min(same, key=_effort)


def _effort(description: dict[str, Any]) -> int:
    """Returns how hard a description is to read: changed keys are easier than changed text."""
    return len(json.dumps(description, ensure_ascii=False)) + 60 * ("replace" in description)


def _value(body: bytes) -> dict[str, Any] | None:
    """The object whose compact JSON these bytes are, if there is one."""

    def refuse(constant: str) -> None:
        raise ValueError(f"JSON has no {constant}")

    quoted = f'"{REQUEST}"'.encode()
    text = body.replace(quoted, REQUEST.encode()).replace(REQUEST.encode(), quoted)
    try:
        value = json.loads(text, parse_constant=refuse)
        return value if isinstance(value, dict) and text_of(value) == body else None
    except (ValueError, RecursionError):
        return None


def _changes(body: bytes, value: Any, base: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if value is not None:
        without, added = _difference(base, value)
        change = {"without": without} if without else {}
        yield change | ({"with": added} if added else {})
    text = text_of(base)
    before, found, after = body.partition(text)
    if found:
        around = {"before": split(before), "after": split(after)}
        yield {key: pieces for key, pieces in around.items() if pieces}
    start, end = _common(text, body)
    while start and not _is_unique_word(text, start, end):
        start -= 1
    if _is_unique_word(text, start, end):
        new = split(body[start : len(body) - (len(text) - end)])
        yield {"replace": text[start:end].decode(errors="replace"), "by": new}


def _common(text: bytes, other: bytes) -> tuple[int, int]:
    """Returns where `text` begins and ends to differ from another."""
    most = min(len(text), len(other))
    start = next((at for at in range(most) if text[at] != other[at]), most)
    tail = next((at for at in range(most - start) if text[-1 - at] != other[-1 - at]), most - start)
    return start, len(text) - tail


def _is_unique_word(text: bytes, start: int, end: int) -> bool:
    found = text[start:end]
    begins_inside = re.fullmatch(rb"\w\w", text[max(start - 1, 0) : start + 1])
    return bool(text.count(found) == 1 and re.search(rb"[a-z]", found) and not begins_inside)


def _difference(base: dict[str, Any], value: dict[str, Any]) -> tuple[list[str], dict[str, Any]]:
    without = [key for key in base if key not in value]
    added: dict[str, Any] = {}
    for key, it in value.items():
        if key in base and json.dumps(base[key]) == json.dumps(it):
            continue
        if isinstance(it, dict) and isinstance(base.get(key), dict):
            less, more = _difference(base[key], it)
            if len(less) + len(more) == 1 and "." not in "".join([*less, *more]):
                without += [f"{key}.{inner}" for inner in less]
                added |= {f"{key}.{inner}": item for inner, item in more.items()}
                continue
        added[key] = it
    return without, added

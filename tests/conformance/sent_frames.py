"""The frames that a malformed case sends, as changes of valid ones. See README.md."""

from typing import Any

from bodies import REQUEST, VALID
from frame_bytes import KINDS, header, json_bytes
from pieces import Piece, joined

Part = Piece | dict[str, Any]


def bytes_of(parts: list[Part]) -> bytes:
    return b"".join(
        _frame(part) if isinstance(part, dict) and "frame" in part else joined([part])
        for part in parts
    )


def _frame(part: dict[str, Any]) -> bytes:
    body = _body(part)
    fields = part.get("header", {})
    fields = fields | ({"magic": fields["magic"].encode()} if "magic" in fields else {})
    kind = KINDS.get(part["frame"], part["frame"])
    whole = header(kind, **({"length": len(body)} | fields)) + body
    return whole[: len(whole) - part.get("cut_bytes", 0)]


def _body(part: dict[str, Any]) -> bytes:
    if "body" in part:
        return joined(part["body"])
    if "json" in part:
        return _text_of(part["json"])
    body = VALID.get(part.get("valid", part["frame"]), [])
    if isinstance(body, list):
        return joined(body)
    for path in part.get("without", []):
        body = _changed(body, path.split("."))
    for path, value in part.get("with", {}).items():
        body = _changed(body, path.split("."), value)
    text = _text_of(body)
    if "replace" in part:
        assert text.count(part["replace"].encode()) == 1, part
        text = text.replace(part["replace"].encode(), joined(part["by"]))
    return joined(part.get("before", [])) + text + joined(part.get("after", []))


def _text_of(body: Any) -> bytes:
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

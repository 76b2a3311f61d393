"""Bytes in case files: a list of pieces, one after the other. README.md describes them."""

import re
from collections.abc import Iterator
from typing import Any

# A text, or an object with `text`, `hex` or `pattern`.
Piece = str | dict[str, Any]
_LEAST_RUN = 100
_RUN = re.compile(rb"(.)\1{%d,}" % _LEAST_RUN, re.DOTALL)
_ASCII = re.compile(rb"([ -~]{3,})")
_HEX_GROUP_BYTES = 4
PATTERN = "index mod 251"


def joined(pieces: list[Piece]) -> bytes:
    return b"".join(_bytes(piece) for piece in pieces)


def _bytes(piece: Piece) -> bytes:
    match piece:
        case str():
            return piece.encode()
        case {"hex": text}:
            return bytes.fromhex(text) * int(piece.get("times", 1))
        case {"text": text}:
            return str(text).encode() * int(piece.get("times", 1))
        case {"pattern": _, "length": length}:
            return bytes(index % 251 for index in range(length))
    raise ValueError(f"not a piece of bytes: {piece}")


def split(data: bytes) -> list[Piece]:
    """The pieces of `data`: texts where it is UTF-8 that people can read."""
    return list(_split(data))


def _split(data: bytes) -> Iterator[Piece]:
    at = 0
    for run in _RUN.finditer(data):
        yield from _plain(data[at : run.start()])
        (piece,) = _plain(run[1])
        shown = {"text": piece} if isinstance(piece, str) else piece
        yield {**shown, "times": len(run[0])}
        at = run.end()
    yield from _plain(data[at:])


def _plain(data: bytes) -> Iterator[Piece]:
    try:
        yield from [text] if (text := data.decode()) and _is_readable(text) else []
        if _is_readable(text):
            return
    except UnicodeDecodeError:
        pass
    for part in _ASCII.split(data):
        if part:
            yield part.decode() if _ASCII.fullmatch(part) else hex_piece(part)


def _is_readable(text: str) -> bool:
    return all(it.isprintable() or it in "\n\r\t\x1b" for it in text)


def hex_piece(data: bytes) -> Piece:
    return {"hex": data.hex(" ", -_HEX_GROUP_BYTES)}

"""Bytes in case files: a list of pieces, one after the other. README.md describes them."""

from typing import Any

# A text, or an object with `text`, `hex` or `pattern`.
Piece = str | dict[str, Any]
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


def hex_piece(data: bytes) -> Piece:
    return {"hex": data.hex(" ", -_HEX_GROUP_BYTES)}

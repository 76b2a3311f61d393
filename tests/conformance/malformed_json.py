"""Bodies that are not the JSON they should be, for whoever reads the first body of a connection."""

import json

from bodies import Body
from frame_bytes import KIB, frame, json_bytes, pascal
from malformed_case import Case, error


def nested(levels: int) -> bytes:
    return b"[" * levels + b"]" * levels


def json_cases(name: str, given: str, lane: str, body: Body, text_key: str) -> dict[str, Case]:
    """`text_key` names a string of `body` that a case may replace."""
    good = json_bytes(body)
    text = json_bytes(body[text_key])

    def with_text(value: bytes) -> bytes:
        return good.replace(text, value, 1)

    def with_later(value: bytes) -> bytes:
        return good[:-1] + b',"later":' + value + b"}"

    bodies = {
        "Empty": (b"", "An empty body is not JSON."),
        "NotJson": (b"\x00\x01\x00\x00" + bytes(60), "Binary where JSON belongs."),
        "Array": (b"[" + good + b"]", "A body is one object."),
        "Null": (b"null", "A body is one object."),
        "Unfinished": (good[:-1], "The length is right, the closing brace is not there."),
        "TextAfter": (good + b"{}", "Nothing follows the object."),
        "ZeroAfter": (good + b"\x00", "Nothing follows the object, not even a C string's end."),
        "ByteOrderMark": (b"\xef\xbb\xbf" + good, "JSON on a network has no byte order mark."),
        "Utf16": (json.dumps(body).encode("utf-16-le"), "JSON is UTF-8."),
        "InvalidUtf8": (with_text(b'"\xc3\x28"'), "A two-byte sequence without its second byte."),
        "OverlongUtf8": (with_text(b'"\xc0\x80"'), "NUL in two bytes is not UTF-8."),
        "EncodedSurrogate": (with_text(b'"\xed\xa0\x80"'), "UTF-8 has no surrogates."),
        "LoneSurrogate": (
            with_text(b'"\\ud800"'),
            "Half a character: no log or topic can carry it.",
        ),
        "ControlCharacter": (with_text(b'"a\nb"'), "JSON strings escape line feeds."),
        "SingleQuotes": (with_text(b"'a'"), "JSON quotes are double."),
        "Comment": (b"/* */" + good, "JSON has no comments."),
        "TrailingComma": (good[:-1] + b",}", "JSON has no trailing comma."),
        "NaN": (with_later(b"NaN"), "JSON has no NaN, not even under a key that is ignored."),
        "Infinity": (with_later(b"-Infinity"), "JSON has no infinity."),
        "SeventeenDeep": (with_later(nested(16)), "One level more than 16."),
        "VeryDeep": (with_later(nested(30 * KIB)), "Must not overflow the reader's stack."),
        "DeepOpenOnly": (b"[" * 60 * KIB, "Must not overflow the reader's stack."),
    }
    return {
        f"{pascal(name)}{label}": Case(given, lane, frame(name, sent), error("malformed"), why)
        for label, (sent, why) in bodies.items()
    }

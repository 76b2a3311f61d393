"""One malformed vector: what is sent, when, and what has to come of it. See README.md."""

from dataclasses import dataclass
from typing import Any

from bodies import REQUEST, VALID, Body
from case_files import crc32
from frame_bytes import frame, pascal
from sent_frames import described, text_of


@dataclass(frozen=True)
class Case:
    given: str
    lane: str
    sent: bytes
    expect: dict[str, Any]
    why: str
    cut: bool = False

    def vector(self, side: str) -> dict[str, Any]:
        case: dict[str, Any] = {"side": side, "lane": self.lane, "given": self.given}
        case |= {"cut": True} if self.cut else {}
        case |= {"sent": described(self.sent, VALID), "crc32": crc32(self.sent)}
        return case | {"expect": self.expect, "why": self.why}


def error(code: str) -> dict[str, Any]:
    return {"error": code}


def body_frame(name: str, body: Any) -> bytes:
    """A frame with a JSON body, in which the number REQUEST is replaced when it is played."""
    return frame(name, text_of(body))


def wrong_type(value: Any) -> Any:
    """A value of another JSON type that careless readers take for the right one."""
    match value:
        case bool():
            return int(value)
        case int() | float():
            return str(value)
        case str() if value == REQUEST:
            return "1"
        case str():
            return 1
        case list():
            return {}
        case _:
            return []


def key_cases(name: str, given: str, lane: str, body: Body, nested: str = "") -> dict[str, Case]:
    """Each key of `body`, or of the object at its key `nested`, once missing, once mistyped."""
    cases = {}
    target = body[nested] if nested else body
    for key in target:
        without = {k: v for k, v in target.items() if k != key}
        typed = target | {key: wrong_type(target[key])}
        path = f"{nested}.{key}" if nested else key
        for label, part in (("Without", without), ("Mistyped", typed)):
            whole = body | {nested: part} if nested else part
            sent = body_frame(name, whole)
            why = f"{name} needs `{path}`" + (" in its type." if label == "Mistyped" else ".")
            case_name = f"{pascal(name)}{label}{pascal(path)}"
            cases[case_name] = Case(given, lane, sent, error("malformed"), why)
    return cases


def over_bound(
    name: str, header_bytes: bytes, given: str, lane: str, bound: int
) -> dict[str, Case]:
    why = f"{name} is longer than {bound} bytes; refused by its header alone."
    return {f"{pascal(name)}TooLarge": Case(given, lane, header_bytes, error("too_large"), why)}

"""Messages of the Kotlin, C, C# and shell sources, found by how each language tells them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from document import files
from message import HOLE, Message

# What is filled in may have texts of its own.
_FILLED_IN = re.compile(r"\$\{(?:[^{}\n]|\{[^{}\n]*\})*\}|\$[A-Za-z*]\w*|%[-.0-9]*(?:ll)?[a-z]")
_FILLED_IN_CSHARP = re.compile(r"\{[^{}\n]*\}")
_LITERAL = r'"(?:[^"\\\n]|\\.)*"'
# Literals that follow each other, with the names of others between them; or one name of a text.
_TOLD = rf"(?P<told>(?:\$?{_LITERAL}|[A-Z_]{{3,}}\b|[\s+])+|\w+(?=[()]))"
_TELLING = {
    ".kt": r"(?<!class )\b(?:Refused|UsageError|InUse|PermissionDenied"
    rf"|(?!Certificate|NotPaired|Protocol|Recording|Serialization)\w+Exception)\(\s*{_TOLD}",
    ".c": rf"error_set\(\s*error, \w+, \w+,\s*{_TOLD}",
    ".cs": rf"(?:new (?:\w*Exception|BuildCheck)\(|Debug\.Log\w+\(|Unavailable =)\s*{_TOLD}",
    ".sh": rf"(?m:\bfail |^\s*echo (?=.*>&2)){_TOLD}",
}
_PLACES = (
    "ml2-sensors-aar/src/main/*.kt",
    "ml2-sensors-aar/app/src/main/*.kt",
    "ml2-sensors-aar/simulator/src/main/*.kt",
    "native/sdk/*.c",
    "native/sources/*.c",
    "native/openxr/*.c",
    "unity_package/Runtime/*.cs",
    "unity_package/Editor/*.cs",
    "unity_package/OpenXR/*.cs",
    "host_receiver/environment/*.sh",
    "ml2-sensors-aar/simulator/ml2-headset",
)


def messages_of_others() -> Iterator[Message]:
    for file in files(*_PLACES):
        if file.parent.name == "cdr":  # told to programs
            continue
        source = _source(file)
        for told in re.finditer(_TELLING[file.suffix or ".sh"], source):
            line = source.count("\n", 0, told.start()) + 1
            for text in _texts(told["told"], file, source):
                yield Message.at(file, line, text)


def _source(file: Path) -> str:
    filled_in = _FILLED_IN_CSHARP if file.suffix == ".cs" else _FILLED_IN
    return filled_in.sub(HOLE, file.read_text())


def _texts(told: str, file: Path, source: str) -> Iterator[str]:
    """The text, with a hole for each name in it; of a name alone, what its definition says."""
    if '"' in told:
        parts = re.findall(rf"{_LITERAL}|\w+", told)
        yield "".join(it[1:-1] if it[0] == '"' else HOLE for it in parts).replace('\\"', '"')
        return
    for other in [file, *sorted(file.parent.glob("*.kt"))]:
        definition = re.search(rf"\b(?:val|fun) {told}\b.*?(?:\n\n|\Z)", _source(other), re.DOTALL)
        if definition:
            for literal in re.findall(_LITERAL, definition[0]):
                if " " in literal:
                    yield literal[1:-1]
            return

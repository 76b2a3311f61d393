"""Case files below vectors/, as every runner reads them. README.md describes their keys."""

import json
import zlib
from fnmatch import fnmatch
from functools import cache
from typing import Any, NamedTuple

from bodies import VECTORS
from pieces import joined
from sent_frames import bytes_of


class Vector(NamedTuple):
    """A case by its name, with the bytes that it describes."""

    name: str
    case: dict[str, Any]
    data: bytes


@cache
def load(folder: str) -> dict[str, Vector]:
    """All cases of a folder, in the order of their names."""
    cases = {
        name: case
        for file in (VECTORS / folder).glob("*.json")
        for name, case in json.loads(file.read_text("utf-8")).items()
    }
    assert cases, f"there are no cases in {VECTORS / folder}"
    return {name: Vector(name, cases[name], _data(cases[name])) for name in sorted(cases)}


def named(folder: str, names: str = "*") -> list[Vector]:
    """The cases of a folder whose names match the pattern `names`."""
    return [vector for name, vector in load(folder).items() if fnmatch(name, names)]


def _data(case: dict[str, Any]) -> bytes:
    data = bytes_of(case["sent"]) if "sent" in case else joined(case.get("bytes", []))
    assert case.get("crc32", crc32(data)) == crc32(data), case
    return data


def crc32(data: bytes) -> str:
    return f"{zlib.crc32(data):08x}"


def text(cases: dict[str, Any], *rows: str) -> bytes:
    """A case file. Each of `rows` names keys that stand in one line; other keys have their own."""
    shown = ",\n".join(_case(name, case, rows) for name, case in cases.items())
    return f"{{\n{shown}\n}}\n".encode()


def _case(name: str, case: Any, rows: tuple[str, ...]) -> str:
    if not rows:
        return f"  {_json(name)}: {_json(case)}"
    keys = [row.split() for row in rows]
    rest = [[key] for key in case if key not in " ".join(rows).split()]
    lines = [
        [f"{_json(key)}: {_json(case[key])}" for key in row if key in case] for row in keys + rest
    ]
    inner = ",\n".join("    " + ", ".join(line) for line in lines if line)
    return f"  {_json(name)}: {{\n{inner}\n  }}"


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)

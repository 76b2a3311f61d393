"""The conformance vectors, from which every target begins."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

HEADER_BYTES = 32
_FOLDER = Path(__file__).parent.parent / "conformance" / "vectors"
# A good exchange: fingerprint, nonce, token, certificate, signature.
PAIRING: dict[str, str] = json.loads((_FOLDER / "pairing" / "Signature.json").read_text("utf-8"))


def words() -> set[str]:
    """The texts in bodies: keys, kinds and names."""
    files = (_FOLDER / "wire").glob("*.bin")
    return {it.decode() for file in files for it in re.findall(rb'"[a-z_/]+"', file.read_bytes())}


class Vector(NamedTuple):
    """What a JSON case says, and the bytes beside it."""

    case: dict[str, Any]
    data: bytes


def vectors(folder: str, names: str = "*") -> Iterator[Vector]:
    """Those of a folder whose name matches."""
    for file in sorted((_FOLDER / folder).glob(f"{names}.bin")):
        case = json.loads(file.with_suffix(".json").read_text("utf-8"))
        yield Vector(case, file.read_bytes())

"""The conformance vectors, from which every target begins."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parent.parent / "conformance"))

from case_files import load, named

HEADER_BYTES = 32
# A good exchange: fingerprint, nonce, token, certificate, signature.
PAIRING: dict[str, str] = load("pairing")["Signature"].case


def words() -> set[str]:
    """The texts in bodies: keys, kinds and names."""
    texts = (re.findall(rb'"[a-z_/]+"', vector.data) for vector in named("wire"))
    return {text.decode() for found in texts for text in found}


def vectors(folder: str, names: str = "*") -> Iterator[tuple[dict[str, Any], bytes]]:
    """The cases of a folder whose names match, each with its bytes."""
    return ((vector.case, vector.data) for vector in named(folder, names))

"""Writes the conformance vectors that every language reads, or verifies the committed ones.

Needs nothing but Python. Each folder below vectors/ is made by a module of its own.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import axes_vectors
import cdr_vectors
import malformed_vectors
import pairing_vectors
import wire_vectors
from bodies import VALID
from case_files import VECTORS, text

FOLDERS: dict[str, Callable[[], dict[str, bytes]]] = {
    "axes": axes_vectors.files,
    "cdr": cdr_vectors.files,
    "wire": wire_vectors.files,
    "malformed": malformed_vectors.files,
    "pairing": pairing_vectors.files,
    "valid": lambda: {"bodies.json": text(VALID)},
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--verify", action="store_true", help="write nothing; fail on a difference")
    arguments = parser.parse_args()

    wanted = {
        VECTORS / folder / name: content
        for folder, files in FOLDERS.items()
        for name, content in files().items()
    }
    present = {path: path.read_bytes() for path in VECTORS.rglob("*") if path.is_file()}
    stale = sorted(
        path for path in wanted.keys() | present.keys() if wanted.get(path) != present.get(path)
    )
    for path in stale:
        print(f"{'stale' if arguments.verify else 'written'}: {path.relative_to(VECTORS)}")
        if not arguments.verify:
            write(path, wanted.get(path))
    return 1 if stale and arguments.verify else 0


def write(path: Path, content: bytes | None) -> None:
    if content is None:
        path.unlink()
    else:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


if __name__ == "__main__":
    sys.exit(main())

"""Completes the conformance vectors that every language reads, or verifies the committed ones.

It writes the files of axes and cdr, and crc32 of the malformed cases; people write everything else.
Needs nothing but Python.
"""

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

import axes_vectors
import cdr_vectors
from bodies import VECTORS
from case_files import crc32, text
from sent_frames import bytes_of


def malformed() -> dict[str, bytes]:
    """The files as they are, with crc32 of what each case sends."""
    return {file.name: _with_crc32(file) for file in (VECTORS / "malformed").iterdir()}


def _with_crc32(file: Path) -> bytes:
    cases = {
        name: case | {"crc32": crc32(bytes_of(case["sent"]))}
        for name, case in json.loads(file.read_text("utf-8")).items()
    }
    return text(cases, "side given lane ros cut", "sent", "expect crc32", "why")


FOLDERS: dict[str, Callable[[], dict[str, bytes]]] = {
    "axes": axes_vectors.files,
    "cdr": cdr_vectors.files,
    "malformed": malformed,
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
    stale = {path: content for path, content in wanted.items() if path.read_bytes() != content}
    for path, content in stale.items():
        print(f"{'stale' if arguments.verify else 'written'}: {path.relative_to(VECTORS)}")
        if not arguments.verify:
            path.write_bytes(content)
    return 1 if stale and arguments.verify else 0


if __name__ == "__main__":
    sys.exit(main())

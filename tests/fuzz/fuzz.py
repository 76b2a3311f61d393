"""Looks for bytes that one of our readers mistakes, guided by what of it they reach (libFuzzer).

Usage: fuzz.py TARGET [FILE or FOLDER or option of libFuzzer]...

A target is one of the modules *_target.py here: read() takes bytes of a stranger and fails for
what must not happen, seeds() are inputs to begin with. Given a FILE it is only read, which
reproduces what was found. Without TARGET, prints their names.
"""

import importlib
import json
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import atheris  # type: ignore[import-untyped]

from vectors import words

_SUFFIX = "_target"
_ROOT = Path(__file__).parent.parent.parent
sys.path += [str(_ROOT / "host_receiver" / "test"), str(_ROOT / "tests" / "conformance")]


def main(target: str, arguments: list[str]) -> None:
    with atheris.instrument_imports(include=["ml2_receiver", "ml2_tools"]):
        module = importlib.import_module(target + _SUFFIX)

    def read(data: bytes) -> None:
        if len(data) >= 2:
            module.read(data)

    with tempfile.TemporaryDirectory(prefix="ml2_fuzz_") as name:
        if not any(Path(it).is_file() for it in arguments):
            arguments += beginning(Path(name), module.seeds())
        atheris.Setup([sys.argv[0], *arguments], read)
        atheris.Fuzz()


def beginning(folder: Path, seeds: Iterable[bytes]) -> list[str]:
    """Returns libFuzzer's arguments for the initial corpus."""
    (folder / "seeds").mkdir()
    for number, seed in enumerate(seeds):
        (folder / "seeds" / str(number)).write_bytes(seed)
    entries = [json.dumps(word) for word in words()]
    (folder / "words").write_text("\n".join(entries))
    return [str(folder / "seeds"), f"-dict={folder / 'words'}"]


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(sys.argv[1], sys.argv[2:])
    else:
        for file in sorted(Path(__file__).parent.glob(f"*{_SUFFIX}.py")):
            print(file.stem.removesuffix(_SUFFIX))

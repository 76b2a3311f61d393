"""Reads the documents of this repository."""

import fnmatch
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def files(pattern: str = "*") -> list[Path]:
    """Returns the files of this repository, also those that are not committed yet."""
    if not (ROOT / ".git").exists():
        return sorted(_unpacked(pattern))
    command = ["git", "ls-files", "-co", "--exclude-standard", "-z", pattern]
    names = subprocess.check_output(command, cwd=ROOT, text=True).split("\0")
    return [file for name in names if name and (file := ROOT / name).exists()]


def _unpacked(pattern: str) -> Iterator[Path]:
    """Returns the files of an unpacked archive, without the folders that git would ignore."""
    ignored = {line.strip("/") for line in (ROOT / ".gitignore").read_text().splitlines()}
    for folder, folders, names in ROOT.walk():
        folders[:] = [it for it in folders if it not in ignored]
        yield from (folder / name for name in fnmatch.filter(names, pattern))


def blocks(text: str, language: str) -> list[str]:
    """Returns the fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def without_spacing(code: str) -> str:
    return " ".join(code.split())


def commands(text: str) -> list[str]:
    """Returns the lines of the fenced blocks of the shell."""
    return [line for block in blocks(text, "shell") for line in block.splitlines() if line]

"""Reads the documents of this repository."""

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def files(*patterns: str) -> list[Path]:
    """Returns the files of this repository, also those that are not committed yet."""
    command = ["git", "ls-files", "-co", "--exclude-standard", "-z", *patterns]
    names = subprocess.check_output(command, cwd=ROOT, text=True).split("\0")
    return [file for name in names if name and (file := ROOT / name).exists()]


def blocks(text: str, language: str) -> list[str]:
    """Returns the fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def without_spacing(code: str) -> str:
    return " ".join(code.split())


def commands(text: str) -> list[str]:
    """Returns the lines of the fenced blocks of the shell."""
    return [line for block in blocks(text, "shell") for line in block.splitlines() if line]

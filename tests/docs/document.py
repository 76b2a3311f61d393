"""What is read of the documents of this repository."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from textwrap import dedent

ROOT = Path(__file__).resolve().parents[2]


def files(*patterns: str) -> list[Path]:
    """Those of this repository, also such as are not committed yet."""
    command = ["git", "ls-files", "-co", "--exclude-standard", "-z", *patterns]
    names = subprocess.check_output(command, cwd=ROOT, text=True).split("\0")
    return [file for name in names if name and (file := ROOT / name).exists()]


def blocks(text: str, language: str) -> list[str]:
    """The fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def indented_blocks(text: str) -> list[str]:
    """The code that is indented by four behind an empty line, without that indent."""
    found = re.findall(r"(?<=\n\n)(?:(?: {4}.*)?\n)+", text)
    return [dedent(block).strip("\n") for block in found if block.strip()]


def without_spacing(code: str) -> str:
    return " ".join(code.split())


def commands(text: str) -> list[str]:
    """The lines that are indented as code."""
    return re.findall(r"^ {4}(\S.*)$", re.sub(r"^```.*?^```$", "", text, flags=re.S | re.M), re.M)

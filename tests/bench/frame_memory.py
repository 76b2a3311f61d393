"""The memory that libml2sensors.so maps for frames in a headset's process."""

import os
import subprocess
from pathlib import Path
from typing import NamedTuple

from processes import ROOT

_SOURCES = ROOT / "tests" / "bench"


class FrameMemory(NamedTuple):
    """In bytes.

    Attributes:
        peak: the most that was mapped at a time.
        left: what is still mapped at the end, which a stream leaked.
        used: the pages of unmapped memory that had been written to.
    """

    peak: int
    left: int
    used: int


def record_frame_memory(folder: Path) -> Path:
    """Has headsets that this process starts write a file for read_frame_memory(); its path."""
    library, file = folder / "libmapped.so", folder / "mapped.txt"
    script = f"-Wl,--version-script={_SOURCES / 'mapped.map'}"
    command = ["cc", "-shared", "-fPIC", "-O2", script, "-o", library, _SOURCES / "mapped.c"]
    subprocess.run([str(it) for it in command], check=True)
    os.environ |= {"LD_PRELOAD": str(library), "ML2S_MAPPED": str(file)}
    return file


def read_frame_memory(file: Path) -> FrameMemory:
    return FrameMemory(*map(int, file.read_text().split()))

"""Which files a recording has, and in which order."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import yaml

from ml2_receiver.errors import RecordingError

_SUFFIX = ".mcap"


def bag_files(path: Path, first_ns: Callable[[Path], int | None]) -> list[Path]:
    """Returns the files of a recording in the order of their messages.

    In a folder they are those that metadata.yaml names, as rosbag2 wrote it. Without it they are
    all .mcap files, by the time of their first message: names say nothing reliable.

    Args:
        path: a folder, or one file.
        first_ns: returns the time of a file's first message, or None if it has none.

    Raises:
        RecordingError: there are none, one is missing, or two have the same messages.
    """
    if not path.is_dir():
        return [path]
    if (named := _named(path)) is not None:
        return named
    files = sorted(path.glob(f"*{_SUFFIX}"))
    if not files:
        others = sorted(it.name for it in path.iterdir() if _is_unsupported(it))
        if others:
            raise _unsupported(path / others[0])
        raise RecordingError(f"expected {_SUFFIX} files in {path}, found none")
    times = {file: first_ns(file) for file in files}
    ordered = sorted(files, key=lambda it: (times[it] is None, times[it] or 0))
    for one, other in pairwise(ordered):
        if times[one] == times[other] is not None:
            raise RecordingError(
                f"{one} and {other.name} begin with the same message",
                hint="One is a copy of the other: name one of the files instead of the folder.",
            )
    return ordered


def _named(folder: Path) -> list[Path] | None:
    """The files that metadata.yaml names; None without one."""
    metadata = folder / "metadata.yaml"
    try:
        document = yaml.load(metadata.read_bytes(), getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        information = document["rosbag2_bagfile_information"]
        files = [folder / Path(name).name for name in information["relative_file_paths"]]
        mode = str(information.get("compression_mode", "")).upper()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RecordingError(f"cannot read {metadata}: {error.strerror}") from error
    except (yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise RecordingError(
            f"{metadata} names no files: {' '.join(str(error).split())}",
            hint="Remove it: then all .mcap files of the folder are read.",
        ) from error
    if mode == "MESSAGE":
        raise RecordingError(
            f"not supported: {folder} has messages compressed one by one (MESSAGE)",
            hint="Convert it with `ros2 bag convert`, or record with compressed chunks instead.",
        )
    for file in files:
        if _is_unsupported(file):
            raise _unsupported(file)
        if not file.exists():
            raise RecordingError(
                f"{metadata} names {file.name}, which is not there",
                hint="Bring it back, or remove metadata.yaml to read the other files.",
            )
    return files or None


def _is_unsupported(file: Path) -> bool:
    return file.name.endswith((".db3", ".mcap.zstd", ".db3.zstd"))


def _unsupported(file: Path) -> RecordingError:
    if file.name.endswith(".mcap.zstd"):
        return RecordingError(
            f"not supported: {file.name} is compressed as a whole (compression_mode FILE)",
            hint=f"Unpack it: zstd --decompress {file}",
        )
    return RecordingError(
        f"not supported: {file.name} is in rosbag2's SQLite format",
        hint="Convert it to MCAP with `ros2 bag convert`.",
    )

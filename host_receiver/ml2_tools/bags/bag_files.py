"""Finds the files of a recording."""

from pathlib import Path
from typing import Any

import yaml

from ml2_receiver.configuration.whole_file import read_file
from ml2_receiver.errors import RecordingError

from .foreign_formats import unsupported_by_name

_SUFFIX = ".mcap"
_MOST_METADATA_BYTES = 16 << 20
_EXPECTED = "expected rosbag2_bagfile_information with a list of relative_file_paths"
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def bag_files(path: Path) -> tuple[list[Path], list[str]]:
    """Returns the files of a recording, and what is left out, in words.

    In a folder they are those that metadata.yaml names, as rosbag2 wrote it. Without it they are
    all .mcap files; names say nothing reliable. An empty one beside others is left out.

    Args:
        path: a folder, or one file.

    Raises:
        RecordingError: there are none, one is missing or of a format that is not read, or the
            folder cannot be read.
    """
    try:
        return _files_of(path) if path.is_dir() else ([path], [])
    except OSError as error:
        raise RecordingError(f"cannot read {error.filename or path}: {error.strerror}") from error


def _files_of(path: Path) -> tuple[list[Path], list[str]]:
    found = sorted({_unpacked(it) for it in path.iterdir()})
    # Such as the ._walk_0.mcap that macOS puts beside a file on a foreign disk.
    hidden = [it for it in found if it.name.startswith(".") and _is_mcap(it)]
    found = [it for it in found if not it.name.startswith(".")]
    there = [it for it in found if _is_mcap(it)]
    others = [error for it in found if (error := unsupported_by_name(it))]
    files = _named(path)
    if files is not None:
        surplus = [it.name for it in there if it not in files]
        left_out = [f"{it}, which metadata.yaml does not name" for it in surplus]
    elif there:
        files, left_out = there, [str(it) for it in others]
    elif others:
        raise others[0]
    else:
        raise RecordingError(
            f"expected {_SUFFIX} files in {path}, found none", hint=_inside(path, found)
        )
    left_out += [f"{it.name}, which is hidden" for it in hidden if it not in files]
    empty = [it for it in files if not it.stat().st_size]
    if len(empty) < len(files):
        files = [it for it in files if it not in empty]
        left_out += [f"{it.name}, which is empty" for it in empty]
    return files, left_out


def _is_mcap(file: Path) -> bool:
    return file.suffix.lower() == _SUFFIX and not file.is_dir()


def _inside(folder: Path, found: list[Path]) -> str:
    """Returns a hint that names the recordings in a folder; empty if there are none."""
    names = [it.name for it in found if it.is_dir() and any(map(_is_mcap, it.iterdir()))]
    return f"Name one of the recordings in {folder}: {', '.join(names)}." if names else ""


def _named(folder: Path) -> list[Path] | None:
    """The files that metadata.yaml names, once each; None without one."""
    metadata = folder / "metadata.yaml"
    try:
        information = _document(metadata)["rosbag2_bagfile_information"]
        named = information["relative_file_paths"]
        files = [_unpacked(_in_folder(folder, name)) for name in named]
        mode = str(information.get("compression_mode", "")).upper()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RecordingError(f"cannot read {metadata}: {error.strerror}") from error
    except (yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        is_yaml = isinstance(error, KeyError | TypeError)
        reason = _EXPECTED if is_yaml else " ".join(str(error).split())
        raise RecordingError(
            f"{metadata} names no files: {reason}",
            hint="Remove it: then all .mcap files of the folder are read.",
        ) from error
    if mode == "MESSAGE":
        raise messages_compressed(folder)
    for file in files:
        if unsupported := unsupported_by_name(file):
            raise unsupported
        if not file.exists():
            raise RecordingError(
                f"{metadata} names {file.name}, which is not there",
                hint="Bring it back, or remove metadata.yaml to read the other files.",
            )
    return list(dict.fromkeys(files)) or None


def _document(metadata: Path) -> Any:
    data = read_file(metadata, _MOST_METADATA_BYTES)
    if len(data) > _MOST_METADATA_BYTES:
        raise ValueError(f"expected at most {_MOST_METADATA_BYTES} B")
    # A few bytes of aliases can stand for gigabytes.
    if any(isinstance(it, yaml.AliasEvent) for it in yaml.parse(data, _LOADER)):
        raise ValueError("found an alias, which rosbag2 does not write")
    return yaml.load(data, _LOADER)


def _in_folder(folder: Path, name: str) -> Path:
    """Early versions of rosbag2 named files with the folder that they were in then."""
    file = folder / name
    return file if file.exists() else folder / file.name


def _unpacked(file: Path) -> Path:
    """The file that somebody unpacked beside a compressed one, or the compressed one."""
    unpacked = file.with_suffix("")
    return unpacked if file.suffix == ".zstd" and unpacked.exists() else file


def messages_compressed(path: Path) -> RecordingError:
    """Returns what to say of a recording whose messages are compressed one by one."""
    return RecordingError(
        f"not supported: {path} has messages compressed one by one (MESSAGE)",
        hint="Convert it with `ros2 bag convert`, or record with compressed chunks instead.",
    )

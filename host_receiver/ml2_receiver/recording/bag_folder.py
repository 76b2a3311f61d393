"""The folder of a recording."""

import shutil
from pathlib import Path

from ..errors import RecordingError, file_hint
from ..private_files import make_private_folder

METADATA = "metadata.yaml"


def make_folder(
    folder: Path,
    *,
    is_overwriting: bool,
    remedy: str = "Choose another folder, or replace the recording with --overwrite.",
) -> None:
    """Makes an empty folder that only its owner can enter.

    With `is_overwriting`, replaces an earlier recording.

    Args:
        remedy: the hint of the error when the folder exists.

    Raises:
        RecordingError: the folder exists, or is not a recording.
    """
    try:
        if folder.exists() or folder.is_symlink():
            if not is_overwriting:
                raise RecordingError(f"{folder} exists already", hint=remedy)
            _check_replaceable(folder)
            shutil.rmtree(folder)
        make_private_folder(folder)
    except OSError as error:
        raise cannot_record(folder, error) from error


def cannot_record(folder: Path, error: OSError) -> RecordingError:
    hint = file_hint(error, "choose another folder")
    return RecordingError(f"cannot record into {folder}: {error.strerror}", hint=hint)


def _check_replaceable(folder: Path) -> None:
    others = (
        [file.name for file in folder.iterdir() if not _is_ours(file)]
        if folder.is_dir() and not folder.is_symlink()
        else [folder.name]
    )
    if others:
        raise RecordingError(
            f"{folder} has more than a recording in it: found {sorted(others)[0]!r}",
            hint="--overwrite replaces recordings only. Choose another folder.",
        )


def _is_ours(file: Path) -> bool:
    return file.is_file() and (file.suffix == ".mcap" or file.name.startswith(METADATA))

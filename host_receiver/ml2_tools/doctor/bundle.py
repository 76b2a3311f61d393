"""Writes the archive that a user attaches to a report, without keys, tokens and images."""

import platform
import re
import zipfile
from collections.abc import Iterator, Mapping
from importlib import metadata
from io import BytesIO
from pathlib import Path
from typing import Any

from ml2_receiver.configuration.whole_file import open_file, replace_file
from ml2_receiver.errors import ReceiverError, file_hint
from ml2_receiver.generated.version import VERSION
from ml2_receiver.json_text import json_text

_MOST_LOGS = 5
_MOST_BYTES = 1_000_000
_OUR_LOGGER = re.compile(rb"\[(?:\w+\.)*ml2_receiver\]")
_REQUIREMENT = re.compile(r"[\w.-]+")
_REMOVED = "<removed>"
_SECRETS = (
    # A log is cut at its beginning, so that a key may lack its first line, or its last one.
    re.compile(r"-----BEGIN [^-]*PRIVATE KEY-----.*?(?:-----END [^-]*PRIVATE KEY-----|\Z)", re.S),
    re.compile(r"\A.*-----END [^-]*PRIVATE KEY-----", re.S),
    re.compile(r"(?<=token=)[^\s&\"']+"),
)


def write_bundle(file: Path, contents: Mapping[str, str | bytes]) -> None:
    """Writes a zip file with these by name; removes private keys and tokens from texts.

    Raises:
        ReceiverError: the file cannot be written.
    """
    archive = BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as bundle:
        for name, it in contents.items():
            bundle.writestr(name, without_secrets(it) if isinstance(it, str) else it)
    try:
        replace_file(file, archive.getvalue())
    except OSError as error:
        raise ReceiverError(
            f"cannot write {file}: {error.strerror}", hint=file_hint(error, "choose another file")
        ) from error


def without_secrets(text: str) -> str:
    """Returns the text with private keys (PEM) and tokens of pairing URIs replaced."""
    for secret in _SECRETS:
        text = secret.sub(_REMOVED, text)
    return text


def as_json(value: Any) -> str:
    """Returns readable JSON."""
    return json_text(value, indent=2, is_ascii=False) + "\n"


def versions(environ: Mapping[str, str]) -> Mapping[str, Any]:
    """Returns the versions of the receiver, of what it needs, and of the system."""
    names = {_REQUIREMENT.match(it) for it in metadata.requires("ml2-receiver") or ()}
    return {
        "ml2_receiver": VERSION,
        "python": platform.python_version(),
        "system": platform.platform(),
        "ros": environ.get("ROS_DISTRO"),
        "rmw": environ.get("RMW_IMPLEMENTATION"),
        "ros_domain_id": environ.get("ROS_DOMAIN_ID"),
        "packages": dict(sorted((it[0], _version(it[0])) for it in names if it)),
    }


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def text_of(file: Path) -> str:
    """Returns the end of a text file, in whole lines; why there is none if it cannot be read."""
    try:
        data = _end(file)
        return data.decode("utf-8")
    except OSError as error:
        return f"{file} cannot be read: {error.strerror}\n"
    except UnicodeDecodeError:
        return f"{file} is not a text file\n"


def _end(file: Path) -> bytes:
    with open_file(file) as stream:
        stream.seek(max(0, file.stat().st_size - _MOST_BYTES))
        if stream.tell():
            stream.readline()
        return stream.read(_MOST_BYTES)


def log_folder(environ: Mapping[str, str]) -> Path:
    """Returns the folder in which ROS 2 writes the logs of nodes."""
    if folder := environ.get("ROS_LOG_DIR"):
        return Path(folder).expanduser()
    return Path(environ.get("ROS_HOME") or Path.home() / ".ros").expanduser() / "log"


def receiver_logs(folder: Path) -> Iterator[Path]:
    """Yields the newest logs of receivers; logs of other nodes stay where they are."""
    found = 0
    for file in sorted(folder.glob("*.log"), key=_changed_s, reverse=True):
        try:
            is_ours = _OUR_LOGGER.search(_end(file)) is not None
        except OSError:
            continue
        if is_ours:
            yield file
            found += 1
        if found == _MOST_LOGS:
            return


def _changed_s(file: Path) -> float:
    try:
        return file.stat().st_mtime
    except OSError:  # another process has removed it
        return 0.0

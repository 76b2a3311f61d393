"""What a headset can do and why it does not do more, from what its receiver says of it."""

from collections.abc import Mapping
from dataclasses import dataclass

from ..configuration.table import Stream, StreamTable

_PERMISSION, _STREAM = "permission.", "stream."


@dataclass(frozen=True)
class DeviceStream:
    """One stream of the table: "runs", "off" or "unavailable", and why if it is known."""

    stream: str
    state: str
    reason: str


@dataclass(frozen=True)
class Device:
    """A headset; `permissions` are Android's, and whether each is granted."""

    name: str
    device_id: str
    software: str
    state: str
    permissions: Mapping[str, bool]
    streams: tuple[DeviceStream, ...]


def read_device(session: Mapping[str, str], table: StreamTable) -> Device | None:
    """From the values of the row "session" of /diagnostics; None when no headset has come yet."""
    if "device_id" not in session:
        return None
    permissions = {name: granted == "true" for name, granted in _under(_PERMISSION, session)}
    answers = dict(_under(_STREAM, session))
    capabilities = session.get("capabilities", "").split()
    return Device(
        session["headset"],
        session["device_id"],
        session.get("software", ""),
        session["state"],
        permissions,
        tuple(
            _stream(stream, table, capabilities, permissions, answers.get(stream.id))
            for stream in table.streams.values()
        ),
    )


def _under(prefix: str, values: Mapping[str, str]) -> list[tuple[str, str]]:
    return [(k.removeprefix(prefix), v) for k, v in values.items() if k.startswith(prefix)]


def _stream(
    stream: Stream,
    table: StreamTable,
    capabilities: list[str],
    permissions: Mapping[str, bool],
    answer: str | None,
) -> DeviceStream:
    result, _, reason = (answer or "").partition(": ")
    needed = table.sections[stream.section].permissions
    missing = [it for it in needed if permissions.get(it) is False]
    if result in ("applied", "adjusted"):
        return DeviceStream(stream.id, "runs", reason)
    if result == "refused":
        return DeviceStream(stream.id, "unavailable", reason)
    if stream.id not in capabilities:
        return DeviceStream(stream.id, "unavailable", "this headset has no such sensor")
    if missing:
        reason = f"permission {', '.join(missing)} is not granted"
        return DeviceStream(stream.id, "unavailable", reason)
    return DeviceStream(stream.id, "off", "the configuration does not enable it")

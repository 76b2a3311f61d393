"""Describes connected headsets: their streams, and why streams do not run."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ml2_receiver.session.stream_state import Judgement, grant
from ml2_receiver.table.stream_table import Stream, StreamTable
from ml2_receiver.topics.adaptation import ADAPTATION, lowered_streams
from ml2_receiver.topics.judgement import read_judgements

_PERMISSION, _STREAM = "permission.", "stream."


@dataclass(frozen=True)
class DeviceStream:
    """One stream of the table: "runs", "silent", "waiting", "paused", "failed", "off" or
    "unavailable".

    `reason` says why if it is known, and what to do. `lowered` is what the headset has lowered for
    the link, in the words of /diagnostics, or empty.
    """

    stream: str
    state: str
    reason: str
    lowered: str = ""


@dataclass(frozen=True)
class Device:
    """A headset; `permissions` are Android's, and whether each is granted."""

    name: str
    device_id: str
    software: str
    state: str
    permissions: Mapping[str, bool]
    streams: tuple[DeviceStream, ...]


def read_device(rows: Mapping[str, Mapping[str, str]], table: StreamTable) -> Device | None:
    """Reads the rows of /diagnostics; returns None if no headset has come yet."""
    session = rows.get("session", {})
    if "device_id" not in session:
        return None
    lowered = lowered_streams(rows.get(ADAPTATION, {}))
    permissions = {name: granted == "true" for name, granted in _under(_PERMISSION, session)}
    answers = dict(_under(_STREAM, session))
    judgements = read_judgements(session)
    capabilities = session.get("capabilities", "").split()
    streams = (
        _stopped(stream.id, judgements.get(stream.id))
        or _stream(stream, table, capabilities, permissions, answers.get(stream.id))
        for stream in table.streams.values()
    )
    return Device(
        session.get("headset", ""),
        session["device_id"],
        session.get("software", ""),
        session.get("state", ""),
        permissions,
        tuple(replace(it, lowered=lowered.get(it.stream, "")) for it in streams),
    )


def _under(prefix: str, values: Mapping[str, str]) -> list[tuple[str, str]]:
    return [(k.removeprefix(prefix), v) for k, v in values.items() if k.startswith(prefix)]


def _stopped(stream: str, judgement: Judgement | None) -> DeviceStream | None:
    """Returns the state of a stream that does not run; None if it runs."""
    if judgement is None or judgement.state == "running":
        return None
    shown = {"refused": "unavailable", "available": "waiting"}
    why = filter(None, (judgement.reason, grant(stream, judgement.permission)))
    return DeviceStream(stream, shown.get(judgement.state, judgement.state), "; ".join(why))


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

"""ML2 Sensors, the headset's app: what it is told over adb, and what it answers.

The commands stand in the README of ml2-sensors-aar/app; only adb's shell may give them.
"""

import secrets
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from ..errors import AdbError, ProtocolError
from ..wire.json_body import JsonBody
from ..wire.messages import ClockStatus, Thermal
from .adb import adb, shell

_INSTALL_HINT = "Install the app of this release: `ml2-receiver headset install`."
PACKAGE = "dev.ml2sensors.app"
# Longer than pairing takes, the slowest of commands.
_ANSWER_TIMEOUT_S = 30.0
_POLL_S = 0.2


@dataclass(frozen=True)
class AppStatus:
    """How the app stands; `reason`: why it is not connected; `news`: of the last command."""

    version: str
    state: Literal["off", "connecting", "connected", "ended"]
    receiver: str
    reason: str
    news: str
    paired: list[str]
    permissions: Mapping[str, bool]
    at_boot: bool
    cools_down: bool
    clock: ClockStatus | None = None
    thermal: Thermal | None = None
    battery_celsius: float | None = None


@dataclass(frozen=True)
class StreamStatus:
    """What became of a stream that the receiver asked for; messages since the start."""

    id: str
    state: Literal["accepted", "waiting", "refused", "failed"]
    reason: str
    produced: int
    dropped: int
    resting: bool


@dataclass(frozen=True)
class Answer(JsonBody):
    """A line of an answer, of which `more` follow."""

    request: str
    more: int
    error: str | None = None
    status: AppStatus | None = None
    stream: StreamStatus | None = None


def start() -> None:
    """Streams, unless it does; asks the receiver anew when permissions have changed."""
    _tell("START")


def stop() -> None:
    _tell("STOP")


def pair(uri: str) -> None:
    """With the receiver that shows `uri`; goes to it and streams."""
    _tell("PAIR", uri=uri)


def go_to(receiver: str) -> None:
    """A name or HOST:PORT; empty for the receiver that is paired, wherever it is."""
    _tell("RECEIVER", receiver=receiver)


def status() -> tuple[AppStatus, Sequence[StreamStatus]]:
    first, *rest = _tell("STATUS")
    if first.status is None:
        raise AdbError("the app answered without its status", hint=_INSTALL_HINT)
    return first.status, [it.stream for it in rest if it.stream is not None]


def grant(permission: str) -> None:
    """As if the user had allowed it."""
    shell("pm", "grant", PACKAGE, permission)


def _tell(action: str, **texts: str) -> Sequence[Answer]:
    """
    Raises:
        AdbError: adb failed, the app is not there, or what it answered instead.
    """
    request = secrets.token_hex(4)
    extras = [word for name, text in texts.items() for word in ("--es", name, text)]
    service = ("-n", f"{PACKAGE}/.StreamingService", "-a", f"{PACKAGE}.{action}")
    printed = shell("am", "start-foreground-service", *service, "--es", "request", request, *extras)
    if "Error" in printed:
        raise AdbError("the app is not on the headset", hint=_INSTALL_HINT)
    answers = _answers(request)
    for it in answers:
        if it.error is not None:
            raise AdbError(f"the app: {it.error}")
    return answers


def _answers(request: str) -> Sequence[Answer]:
    deadline = time.monotonic() + _ANSWER_TIMEOUT_S
    while time.monotonic() < deadline:
        answers = _logged(request)
        if answers and answers[-1].more == 0:
            return answers
        time.sleep(_POLL_S)
    message = f"the app did not answer within {_ANSWER_TIMEOUT_S:.0f} s"
    raise AdbError(message, hint=_INSTALL_HINT)


def _logged(request: str) -> Sequence[Answer]:
    """Every app may write into the log, but knows no request."""
    log = adb("logcat", "-d", "-v", "raw", "-s", "ml2-sensors:I")
    try:
        return [Answer.parse(it.encode()) for it in log.splitlines() if f'"{request}"' in it]
    except ProtocolError as error:
        message = f"the app's answer is not of this version: {error.message}"
        raise AdbError(message, hint=_INSTALL_HINT) from error

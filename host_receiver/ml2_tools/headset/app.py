"""Sends commands over adb to ML2 Sensors, the headset's app, and reads its answers.

The README of ml2-sensors-aar/app describes the commands; only adb's shell may send them.
"""

import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from ml2_receiver.errors import ProtocolError
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.messages import ClockStatus, Thermal

from ..errors import AdbError
from .adb import adb, secret_shell, shell

_INSTALL_HINT = "Install the app of this release: `ml2-receiver headset install`."
PACKAGE = "dev.ml2sensors.app"
# Longer than pairing takes, the slowest command.
_REPLY_TIMEOUT_S = 30.0
_POLL_S = 0.2


@dataclass(frozen=True)
class AppStatus:
    """The status of the app.

    `reason` says why it is not connected. `news` is the result of the last command.
    """

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
    """The status of a stream that the receiver requested.

    `produced` and `dropped` count messages since the start. `resting` is True while the stream is
    off because the headset is hot.
    """

    id: str
    state: Literal["running", "waiting", "refused", "failed"]
    reason: str
    produced: int
    dropped: int
    resting: bool


@dataclass(frozen=True)
class Reply(JsonBody):
    """One line of the app's reply; `more` lines follow."""

    request: str
    more: int
    error: str | None = None
    status: AppStatus | None = None
    stream: StreamStatus | None = None


def start() -> None:
    """Starts streaming; reconnects if permissions have changed since the last start."""
    _send_command("START")


def stop() -> None:
    """Stops streaming."""
    _send_command("STOP")


def pair(uri: str) -> None:
    """Pairs with the receiver that shows `uri`, connects to it and streams."""
    _send_command("PAIR", secret_shell, uri=uri)


def go_to(receiver: str) -> None:
    """Chooses a paired receiver by name or HOST:PORT; empty means the paired one at any address."""
    _send_command("RECEIVER", receiver=receiver)


def status() -> tuple[AppStatus, Sequence[StreamStatus]]:
    """Returns the status of the app and of each stream."""
    first, *rest = _send_command("STATUS")
    if first.status is None:
        raise AdbError("the app answered without its status", hint=_INSTALL_HINT)
    return first.status, [it.stream for it in rest if it.stream is not None]


def grant(permission: str) -> None:
    """Grants an Android permission, as the user can in the app's dialog."""
    shell("pm", "grant", PACKAGE, permission)


def _send_command(action: str, run: Callable[..., str] = shell, **extras: str) -> Sequence[Reply]:
    """Sends a command with extras, and returns the app's reply.

    Raises:
        AdbError: adb failed, the app is not installed, or it answered with an error.
    """
    request = secrets.token_hex(4)
    options = ["--es", "request", request]
    for name, text in extras.items():
        options += ["--es", name, text]
    service = ("-n", f"{PACKAGE}/.StreamingService", "-a", f"{PACKAGE}.{action}")
    output = run("am", "start-foreground-service", *service, *options)
    if "Error" in output:
        raise AdbError("the app is not on the headset", hint=_INSTALL_HINT)
    replies = _replies(request)
    for reply in replies:
        if reply.error is not None:
            raise AdbError(f"the app: {reply.error}")
    return replies


def _replies(request: str) -> Sequence[Reply]:
    deadline = time.monotonic() + _REPLY_TIMEOUT_S
    while time.monotonic() < deadline:
        replies = _logged_replies(request)
        if replies and replies[-1].more == 0:
            return replies
        time.sleep(_POLL_S)
    message = f"the app did not answer within {_REPLY_TIMEOUT_S:.0f} s"
    raise AdbError(message, hint=_INSTALL_HINT)


def _logged_replies(request: str) -> Sequence[Reply]:
    """Returns the lines of the answer to `request` that are in Android's log so far.

    Other apps can write into the log, but they do not know the random `request`.
    """
    log = adb("logcat", "-d", "-v", "raw", "-s", "ml2-sensors:I")
    try:
        return [Reply.parse(it.encode()) for it in log.splitlines() if f'"{request}"' in it]
    except ProtocolError as error:
        message = f"the app's reply does not fit this version of the receiver: {error.message}"
        raise AdbError(message, hint=_INSTALL_HINT) from error

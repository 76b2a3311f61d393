"""Runs a receiver that waits for headsets, which tests start and kill."""

from __future__ import annotations

import contextlib
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from counters import Snapshot, await_snapshot
from processes import (
    PREFIX,
    RECEIVER,
    Received,
    ended,
    isolated_environment,
    listening_address,
    process,
    receive_command,
    result,
    subscribing,
)

_GYRO = f"{PREFIX}/gyro_left/imu"


@dataclass(frozen=True)
class WaitingReceiver:
    """A receiver that waits for a headset, and its subscriber; logs are in `folder`."""

    environment: dict[str, str]
    folder: Path
    receiver: subprocess.Popen[str]
    address: str
    subscriber: subprocess.Popen[str]

    def started(
        self, name: str, command: list[str | Path]
    ) -> contextlib.AbstractContextManager[subprocess.Popen[str]]:
        """Starts one more process with a pipe as its input, which logs to `name`.log."""
        return process(command, self.environment, self.folder / f"{name}.log", subprocess.PIPE)

    def run(self, *command: str) -> subprocess.CompletedProcess[str]:
        """Runs a command of ml2-receiver beside the receiver."""
        return ended([RECEIVER, *command], self.environment)

    def await_seconds(self, count: int) -> None:
        """Waits until a reading has arrived, and `count` seconds longer."""
        self.await_reading(after_s=0.0)
        until_s = time.monotonic() + count
        self.await_snapshot(lambda _: time.monotonic() > until_s)

    def await_reading(self, after_s: float) -> None:
        """Waits for a gyroscope reading that arrives after `after_s` of time.time()."""
        self.await_snapshot(lambda it: it["topics"][_GYRO]["last_s"] > after_s)

    def await_snapshot(self, is_enough: Callable[[Snapshot], bool]) -> Snapshot:
        """Waits until a snapshot of the subscriber is enough, and returns it."""
        return await_snapshot(self.subscriber, is_enough)

    def result(self) -> Received:
        """Waits for the end of the headset and returns the subscriber's result."""
        return result(self.subscriber, self.folder)


@contextlib.contextmanager
def waiting_receiver(config: Path, folder: Path) -> Iterator[WaitingReceiver]:
    """Runs a receiver and its subscriber, without a headset, and ends both at the end."""
    environment = isolated_environment()
    command = receive_command(config, "127.0.0.1:0", "--start-paused")
    with (
        process(command, environment, folder / "receiver.log") as receiver,
        subscribing(environment, folder) as subscriber,
    ):
        yield WaitingReceiver(
            environment, folder, receiver, listening_address(receiver), subscriber
        )

"""Runs a receiver that waits for headsets, which tests start and kill."""

from __future__ import annotations

import contextlib
import json
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from processes import (
    PREFIX,
    RECEIVER,
    Received,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
    result,
    subscribing,
)
from waiting import LIMIT_S

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
        """Starts one more process, which logs to `name`.log."""
        return process(command, self.environment, self.folder / f"{name}.log")

    def run(self, *command: str) -> subprocess.CompletedProcess[str]:
        """Runs a command of ml2-receiver beside the receiver, for 60 s at most."""
        return subprocess.run(
            [RECEIVER, *command],
            env=self.environment,
            stdout=subprocess.PIPE,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )

    def await_seconds(self, count: int) -> None:
        """Waits until readings have arrived for about `count` more seconds."""
        self.await_reading(after_s=0.0)
        for _ in range(count - 1):
            assert next(lines(self.subscriber))

    def await_reading(self, after_s: float) -> None:
        """Waits for a gyroscope reading that arrives after `after_s` of time.time()."""
        for line in lines(self.subscriber):
            if json.loads(line)["topics"][_GYRO]["last_s"] > after_s:
                return
        raise AssertionError("the subscriber ended before a reading arrived")

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

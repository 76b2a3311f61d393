"""A receiver that waits for headsets, which tests start and kill as they like."""

from __future__ import annotations

import contextlib
import json
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from processes import (
    PREFIX,
    Received,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
    result,
    subscribing,
)

_GYRO = f"{PREFIX}/gyro_left/imu"


@dataclass(frozen=True)
class WaitingReceiver:
    """A receiver that waits for a headset, and its subscriber; logs in `folder`."""

    environment: dict[str, str]
    folder: Path
    receiver: subprocess.Popen[str]
    address: str
    subscriber: subprocess.Popen[str]

    def started(
        self, name: str, command: list[str | Path]
    ) -> contextlib.AbstractContextManager[subprocess.Popen[str]]:
        """One more process, logging to `name`.log."""
        return process(command, self.environment, self.folder / f"{name}.log")

    def await_seconds(self, count: int) -> None:
        """Waits until readings have flowed for about so many more seconds."""
        self.await_reading(after_s=0.0)
        for _ in range(count - 1):
            assert next(lines(self.subscriber))

    def await_reading(self, after_s: float) -> None:
        """Waits for a reading of the gyroscope that arrives later than this, of time.time()."""
        for line in lines(self.subscriber):
            if json.loads(line)["topics"][_GYRO]["last_s"] > after_s:
                return
        raise AssertionError("the subscriber ended before")

    def result(self) -> Received:
        """What the subscriber got; waits for the end of the headset."""
        for _ in lines(self.subscriber):
            pass
        return result(self.subscriber, self.folder)


@contextlib.contextmanager
def waiting_receiver(config: Path, folder: Path) -> Iterator[WaitingReceiver]:
    """Yields the receiver; all its processes but those that were started on it end with it."""
    environment = isolated_environment()
    command = receive_command(config, "127.0.0.1:0", "--start-paused")
    with (
        process(command, environment, folder / "receiver.log") as receiver,
        subscribing(environment, folder) as subscriber,
    ):
        yield WaitingReceiver(
            environment, folder, receiver, listening_address(receiver), subscriber
        )

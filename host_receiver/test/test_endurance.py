"""A receiver holds nothing of headsets that have gone."""

from pathlib import Path

import pytest

from configurations import only
from mock_device import MockDevice
from ros_processes import Receiver
from waiting import await_true

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("battery: {enabled: true}")
WARM_UP = 20
RECONNECTS = 200


def held(process: int) -> tuple[int, int]:
    """Threads and open files."""
    folder = Path(f"/proc/{process}")
    return len(list((folder / "task").iterdir())), len(list((folder / "fd").iterdir()))


def reconnect(receiver: Receiver, times: int) -> None:
    for _ in range(times):
        with MockDevice(receiver.address, says_ping=True) as device:
            device.start()
            device.leave()


def test_threads_and_files_do_not_grow_with_reconnects(receiver: Receiver) -> None:
    reconnect(receiver, WARM_UP)
    threads, files = held(receiver.process.pid)
    reconnect(receiver, RECONNECTS)

    def is_as_before() -> bool:
        threads_after, files_after = held(receiver.process.pid)
        return threads_after <= threads + 4 and files_after <= files + 4

    # The last devices' connections may still be closing, four of each
    await_true(is_as_before)

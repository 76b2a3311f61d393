"""Work that a test does beside itself."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from mock_device import MockDevice
from waiting import LIMIT_S


@contextmanager
def repeated(work: Callable[[], None], pause_s: float) -> Iterator[None]:
    """Does `work` in a thread, with pauses between, until it is left."""
    ended = threading.Event()

    def repeat() -> None:
        while not ended.wait(pause_s):
            work()

    thread = threading.Thread(target=repeat)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def connected(device: MockDevice, publish: Callable[[], None]) -> Callable[[], None]:
    """As `publish`, but connects the device again if its session has ended.

    A receiver ends it when the machine stands still for longer than it waits for silent devices.
    """

    def again() -> None:
        try:
            publish()
        except OSError:
            device.disconnect()
            begin(device)

    return again


def begin(device: MockDevice) -> None:
    """Starts a device; again if the machine stands still meanwhile, which ends the session."""
    deadline_s = time.monotonic() + LIMIT_S
    while True:
        try:
            return device.start()
        except (OSError, AssertionError):
            if time.monotonic() > deadline_s:
                raise
            device.disconnect()

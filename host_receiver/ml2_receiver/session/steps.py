"""Steps of the Host by several threads, and the actions that they cause, in one order."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .actions import Action, Log
from .host import Host


class Steps:
    """Lets one thread at a time tell the Host what happened, then performs its actions.

    Actions are performed under another lock, in the order in which all threads have caused them.

    Args:
        perform: performs one action; not called under `host_lock`.

    Attributes:
        host_lock: that of the Host. May be taken under `output_lock`, never the other way round.
        output_lock: held while the sink is called, and while something is sent.
    """

    def __init__(self, host: Host, perform: Callable[[Action], None]) -> None:
        self.host_lock, self.output_lock = threading.Lock(), threading.Lock()
        self._host, self._perform = host, perform

    @contextmanager
    def step(self) -> Iterator[float]:
        """Enters the lock of the Host at a time in s, then performs its actions."""
        with self.host_lock:
            yield time.monotonic()
        with self.output_lock:
            while self._host.actions:
                try:
                    self._perform(self._host.actions.popleft())
                except Exception as error:
                    self._log(error)

    def guarded[T](self, task: Callable[[], T]) -> T | None:
        """Runs a task as a step, and returns None if it failed.

        An exception that nobody expected must not end the thread: the receiver would accept no
        headset any more.
        """
        try:
            with self.step():
                return task()
        except Exception as error:
            self._log(error)
            return None

    def _log(self, error: Exception) -> None:
        text = f"internal error, please report it: {error!r}"
        self._host.actions.append(Log(text, "receiver"))

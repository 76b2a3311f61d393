"""Stops commands on signals."""

import _thread
import atexit
import functools
import os
import signal
import sys
import threading
from collections.abc import Callable
from types import TracebackType
from typing import NoReturn

from ..stop_limit import STOP_LIMIT

INTERRUPTED = 128 + signal.SIGINT
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
# Longer than such a callback takes.
_AGAIN_S = 0.01


def heed_interrupts() -> None:
    """Makes SIGINT raise KeyboardInterrupt even if this process was started to ignore it.

    A shell without job control starts background jobs so, and their children inherit it.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


class _Interrupts:
    """Raises KeyboardInterrupt on SIGINT: once, so that what then ends is not interrupted again.

    Attributes:
        has_raised: it has.
        is_over: the command has ended, and SIGINT ends the process at once.
    """

    def __init__(self) -> None:
        self.has_raised = self.is_over = False

    def hear(self, *_: object) -> None:
        if self.has_raised:
            return
        if self.is_over:
            os._exit(INTERRUPTED)
        self.has_raised = True
        # The main thread may have been interrupted where it holds a lock that a Thread's start
        # takes.
        _thread.start_new_thread(STOP_LIMIT.enforce, ())
        raise KeyboardInterrupt

    def hear_again(self) -> None:
        self.has_raised = False
        os.kill(os.getpid(), signal.SIGINT)


_interrupts = _Interrupts()


def limit_interrupts() -> None:
    """As heed_interrupts(), and ends this process some seconds after SIGINT, whatever hangs.

    The next SIGINT raises nothing.
    """
    _interrupts.has_raised = _interrupts.is_over = False
    signal.signal(signal.SIGINT, _interrupts.hear)
    sys.unraisablehook = _interrupt_again
    sys.excepthook = _show


def _interrupt_again(unraisable: "sys.UnraisableHookArgs") -> None:
    """Interrupts once more after a callback that cannot raise, such as that of a weak reference."""
    if unraisable.exc_type is KeyboardInterrupt:
        threading.Timer(_AGAIN_S, _interrupts.hear_again).start()
    else:
        sys.__unraisablehook__(unraisable)


def _show(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """Shows no interrupt: NumPy's import_array() prints what it then makes an ImportError of."""
    if not issubclass(kind, KeyboardInterrupt):
        sys.__excepthook__(kind, error, trace)


def run_interruptible(command: Callable[[], int]) -> int:
    """Runs a command that has this process to itself, with limit_interrupts(); its exit code.

    Once it is interrupted, the process ends with the exit code of interrupted programs.
    """
    try:
        try:
            limit_interrupts()
            return command()
        finally:
            _interrupts.is_over = True
    finally:
        # A library may have made another error of it.
        if _interrupts.has_raised:
            _end_interrupted()


def _end_interrupted() -> NoReturn:
    """Ends this process; in the handler of its error.

    The interrupt may have come while an object of ROS was made, whose threads then run until the
    end. Python's own end would destroy what they use, and the process would crash.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    atexit._run_exitfuncs()
    sys.stderr.flush()
    os._exit(INTERRUPTED)


class _Hearing:
    """Hears the signals of this process in a thread, for the last stop_signal()."""

    def __init__(self) -> None:
        self._heard, self.told = os.pipe()
        os.set_blocking(self.told, False)
        self.stopping = threading.Event()
        threading.Thread(target=self._hear, name="signals", daemon=True).start()

    def _hear(self) -> None:
        while True:
            if os.read(self._heard, 1)[0] in _SIGNALS:
                STOP_LIMIT.enforce(self.stopping.set)


# One for all commands that a process runs one after another: each has a thread and two files.
_hearing = functools.cache(_Hearing)


def stop_signal() -> threading.Event:
    """Set by Ctrl-C and by SIGTERM, which then end nothing by themselves; for the main thread.

    A process that has not ended some seconds later, because a thread hangs, is ended. The event of
    an earlier call is not set any more.
    """
    hearing = _hearing()
    hearing.stopping = stopping = threading.Event()
    # Python calls a handler when the main thread gets to it. That waits for `stopping`, where it
    # is not always woken up, and where a handler that sets it could lock it a second time.
    signal.set_wakeup_fd(hearing.told)
    for number in _SIGNALS:
        signal.signal(number, lambda *_: None)
    return stopping


def go_on() -> None:
    """Lets a command work on after its stop: the next signal ends it at once; for the main thread.

    The event of stop_signal() stays set.
    """
    signal.set_wakeup_fd(-1)
    limit_interrupts()
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    STOP_LIMIT.reached()

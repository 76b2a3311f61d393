"""How commands end."""

import signal
import threading


def stop_signal() -> threading.Event:
    """Set by Ctrl-C and by SIGTERM, which then end nothing by themselves."""
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    return stopping

"""Runs `ml2-receiver view` beside the receiver, for `run --view`."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def view_beside(name: str) -> Iterator[None]:
    """Runs the page of the receiver with this --name as a process; ends it when left.

    A process of its own costs the receiver's threads nothing. If it fails, it says why, and the
    receiver goes on.
    """
    command = [sys.executable, "-P", "-m", "ml2_receiver", "view", "--name", name]
    with subprocess.Popen(command) as page:
        try:
            yield
        finally:
            page.terminate()

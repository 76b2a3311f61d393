"""Runs `ml2-receiver view` beside the receiver, for `run --view`."""

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def view_beside(name: str, keys: Path, port: int, remappings: Sequence[str]) -> Iterator[None]:
    """Runs the page of the receiver with this --name as a process; ends it when left.

    It follows the receiver's `remappings`, arguments of ROS.

    Pairing on the page uses the folder `keys`, and headsets then connect to `port`.

    A process of its own costs the receiver's threads nothing. If it fails, it says why, and the
    receiver goes on.
    """
    command = [sys.executable, "-P", "-m", "ml2_receiver", "view", "--name", name]
    command += ["--keys", str(keys), "--receiver-port", str(port)]
    if remappings:
        command += ["--ros-args", *remappings]
    with subprocess.Popen(command) as page:
        try:
            yield
        finally:
            page.terminate()

"""A simulated headset for the self-test, which is paired and runs as a process of its own."""

import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from ml2_receiver.errors import ReceiverError

from .pairing import ENDS_WITH_US, pair

_HEADSET = Path(__file__).parents[3] / "ml2-sensors-aar" / "simulator" / "ml2-headset"
_END_S = 10.0
# Drawing takes more processors than most machines have beside a recorder. The world cameras capture
# with low exposure only while a controller is tracked.
_DEFAULTS = ("still_images=1", "controller_tracked=1", "tags=36h11")


@contextmanager
def simulated_headset(
    folder: Path, values: Sequence[str]
) -> Iterator[tuple[list[str], Path, Callable[[], bool]]]:
    """Runs a headset that connects again and again to a port of this machine.

    Args:
        folder: where its keys, those of the receiver, and its log go.
        values: KEY=VALUE of the simulation.

    Yields:
        The options with which `ml2-receiver record` is its receiver, the headset's log, and what
        returns whether it runs.

    Raises:
        ReceiverError: there is no simulated headset here, or it cannot be paired.
    """
    if not _HEADSET.exists():
        raise ReceiverError(
            f"there is no {_HEADSET}", hint="Clone the repository, and run `make demo` there once."
        )
    receiver = ("--keys", str(folder / "receiver"))
    headset = (str(_HEADSET), "--keys", str(folder / "headset"))
    pair([sys.executable, "-P", "-m", "ml2_receiver", "pair", *receiver], headset)
    address = f"127.0.0.1:{_free_port()}"
    log = folder / "headset.log"
    words = [word for it in (*_DEFAULTS, *values) for word in ("--simulate", it)]
    command = [*ENDS_WITH_US, *headset, "--receiver", address, *words]
    with log.open("wb") as output:
        running = subprocess.Popen(command, stdout=output, stderr=output)
    try:
        yield ["--listen", address, *receiver], log, lambda: running.poll() is None
    finally:
        running.terminate()
        try:
            running.wait(_END_S)
        except subprocess.TimeoutExpired:
            running.kill()
            running.wait()


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])

"""Pairs a simulated headset with a receiver of this machine, both with keys of their own."""

import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from ml2_receiver.errors import ReceiverError

_PATIENCE_S = 60
# A process that is started with these words ends when the program that has started it is killed.
ENDS_WITH_US = ("setpriv", "--pdeathsig", "KILL")


def pair(pairing: Sequence[str | Path], headset: Sequence[str | Path]) -> None:
    """Lets `ml2-receiver pair` and `ml2-headset`, each with its --keys, pair on this machine.

    Raises:
        ReceiverError: they did not; the message has their words.
    """
    with offered(pairing) as uri:
        accept(headset, uri)


@contextmanager
def offered(pairing: Sequence[str | Path]) -> Iterator[str]:
    """Runs `ml2-receiver pair` and yields its URI, when the receiver has its key.

    Waits at the end until it has stored the headset that accepted. The command's words to people,
    such as for how long the URI is valid, are shown only if there is no URI.

    Raises:
        ReceiverError: there is no URI; the message has the command's words.
    """
    command = [*ENDS_WITH_US, *map(str, pairing), "--listen", "127.0.0.1:0"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        try:
            uri = process.stdout.readline().strip()
            if not uri:
                raise ReceiverError(process.stderr.read().strip())
            yield uri
            process.wait(_PATIENCE_S)
        finally:
            process.terminate()


def accept(headset: Sequence[str | Path], uri: str) -> None:
    """Lets `ml2-headset` pair.

    Raises:
        ReceiverError: it did not; the message has its words.
    """
    done = subprocess.run(
        [*map(str, headset), "--pair", "-"],
        input=uri,
        capture_output=True,
        text=True,
        timeout=_PATIENCE_S,
        check=False,
    )
    if done.returncode:
        words = done.stderr.strip()
        raise ReceiverError(f"the headset could not be paired with the receiver: {words}")

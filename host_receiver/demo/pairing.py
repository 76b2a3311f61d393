"""Pairs the headset of the demo with its receiver, both with keys of its own."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

_PATIENCE_S = 60


def pair(pairing: Sequence[str | Path], headset: Sequence[str | Path]) -> None:
    """Lets `ml2-receiver pair` and `ml2-headset`, each with its --keys, pair on this machine.

    Raises:
        SystemExit: they did not; they have said why on standard error.
    """
    with offered(pairing) as uri:
        accept(headset, uri)


@contextmanager
def offered(pairing: Sequence[str | Path]) -> Iterator[str]:
    """Runs `ml2-receiver pair` and yields its URI, when the receiver has its key.

    Waits at the end until it has stored the headset that accepted. What it says to people, such as
    for how long the URI is valid, is shown only if there is no URI.

    Raises:
        SystemExit: there is no URI; it says why.
    """
    command = [*map(str, pairing), "--listen", "127.0.0.1:0"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        try:
            uri = process.stdout.readline().strip()
            if not uri:
                raise SystemExit(process.stderr.read())
            yield uri
            process.wait(_PATIENCE_S)
        finally:
            process.terminate()


def accept(headset: Sequence[str | Path], uri: str) -> None:
    """Lets `ml2-headset` pair.

    Raises:
        SystemExit: it did not; it has said why on standard error.
    """
    done = subprocess.run(
        [*map(str, headset), "--pair", "-"],
        input=uri.encode(),
        stdout=subprocess.DEVNULL,
        timeout=_PATIENCE_S,
        check=False,
    )
    if done.returncode:
        raise SystemExit("the headset could not be paired with the receiver")

"""Pairs the headset of the demo with its receiver, both with keys of its own."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

_PATIENCE_S = 60


def pair(pairing: Sequence[str | Path], headset: Sequence[str | Path]) -> None:
    """Lets `ml2-receiver pair` and `ml2-headset`, each with its --keys, pair on this machine.

    Raises:
        SystemExit: they did not; they have said why on standard error.
    """
    command = [*map(str, pairing), "--listen", "127.0.0.1:0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        uri = process.stdout.readline().strip()
        try:
            answer = [*map(str, headset), "--pair", uri]
            if subprocess.call(answer, stdout=subprocess.DEVNULL, timeout=_PATIENCE_S):
                raise SystemExit("the headset could not be paired with the receiver")
            process.wait(_PATIENCE_S)
        finally:
            process.terminate()

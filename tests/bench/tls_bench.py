"""Compares the receiver's CPU time from socket to sink with TLS and in plaintext, in alternation.

The sink discards all messages, so only receiving, decrypting and parsing are measured. CPU is that
of the whole receiving process by getrusage. Results are medians of the repetitions.
"""

import json
import statistics
import sys
import tempfile
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from frames import IMAGE, IMAGE_PAYLOAD, sender
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_receiver.wire.frame import HEADER_BYTES
from ml2_receiver.wire.kinds import Kind
from mock_device import MockDevice
from players import Player, Turn
from tls_device import Certificate

WARM_UP_FRAMES = 50
PING_EVERY = 20  # frames; MockDevice's connections are not thread-safe


def main(results_file: Path, frames: int, repetitions: int) -> None:
    with ExitStack() as stack:
        keys = stack.enter_context(tempfile.TemporaryDirectory())
        paired = Certificate(Path(keys, "device"), "device")
        PairedDevices(Path(keys)).add("device", "device", paired.der)
        players = {
            "plaintext": (Player("session"), None),
            "tls": (Player("session", keys), paired.context()),
        }
        devices: list[MockDevice] = []
        turns: dict[str, tuple[Turn, Callable[[], None]]] = {}
        for name, (player, tls) in players.items():
            stack.enter_context(player)
            device = stack.enter_context(MockDevice(player.line(), tls=tls))
            device.start()
            devices.append(device)
            turns[name] = Turn(player.usage), sender(device, IMAGE, IMAGE_PAYLOAD)
        for count in (min(frames, WARM_UP_FRAMES), *[frames] * repetitions):
            for turn, send in turns.values():
                turn.play(keeping_alive(devices, send), count)
        results = {name: turn.results[1:] for name, (turn, _) in turns.items()}
    results_file.parent.mkdir(parents=True, exist_ok=True)
    measured = summary(results) | {"frames": frames, "repetitions": repetitions}
    results_file.write_text(json.dumps(measured, indent=2) + "\n")


def keeping_alive(devices: list[MockDevice], send: Callable[[], None]) -> Callable[[], None]:
    sent = 0

    def send_and_ping() -> None:
        nonlocal sent
        if sent % PING_EVERY == 0:
            for device in devices:
                device.wires["control"].send(Kind.PING)
        sent += 1
        send()

    return send_and_ping


def summary(results: dict[str, list[tuple[float, float]]]) -> dict[str, float]:
    """Returns the medians of (CPU ms per frame, frames per s) of all repetitions."""
    found: dict[str, float] = {}
    frame_bytes = HEADER_BYTES + len(IMAGE_PAYLOAD)
    for name, turns in results.items():
        cpu_ms, rate = (statistics.median(column) for column in zip(*turns, strict=True))
        found |= {
            f"{name}_cpu_ms_per_frame": cpu_ms,
            f"{name}_frames_per_s": rate,
            f"{name}_gbit_per_s": rate * frame_bytes * 8e-9,
        }
    ratios = [tls[0] / plain[0] for plain, tls in zip(*results.values(), strict=True)]
    return found | {"cpu_ratio": statistics.median(ratios), "frame_bytes": frame_bytes}


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))

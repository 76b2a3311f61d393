"""The receiver's way from socket to sink with TLS beside the same in plaintext, in turns.

The sink takes nothing, so that what is left is receiving, decrypting and parsing. CPU is that of
the whole receiving process, as getrusage tells. Results are medians of the repetitions.
"""

from __future__ import annotations

import json
import statistics
import sys
import tempfile
from contextlib import ExitStack
from functools import partial
from pathlib import Path

from ml2_receiver.commands.printed_events import PrintedEvents
from ml2_receiver.configuration.table import load_table
from ml2_receiver.link.access import Everybody, PairedOnly
from ml2_receiver.link.listener import listen
from ml2_receiver.link.server import Server
from ml2_receiver.security.contexts import device_context
from ml2_receiver.security.identity import Identity
from ml2_receiver.wire.frame import HEADER_BYTES, Kind, encode_frame
from mock_device import MockDevice
from receiver_bench import (
    FRAMES,
    PAYLOAD,
    REPETITIONS,
    REQUEST,
    TOPIC,
    WARM_UP_FRAMES,
    Player,
    Turn,
    answer,
    received,
    send_frame,
)

RESULTS = Path(__file__).resolve().parents[2] / "build" / "bench" / "tls.json"


def main() -> None:
    """Runs the turns and writes build/bench/tls.json."""
    with ExitStack() as stack:
        keys = stack.enter_context(tempfile.TemporaryDirectory())
        context = device_context(Identity.of(Path(keys)))
        turns, devices = {}, []
        for role, tls in (("plaintext", None), ("tls", context)):
            player = stack.enter_context(Player(role, keys, script=__file__))
            device = stack.enter_context(MockDevice(player.line(), tls=tls))
            device.start()
            turns[role] = Turn(player), device
            devices.append(device)
        frame = bytearray(encode_frame(Kind.DATA, PAYLOAD, channel=1))
        for frames in (WARM_UP_FRAMES, *[FRAMES] * REPETITIONS):
            for turn, device in turns.values():
                frame[6:8] = device.channels[TOPIC.name][0].to_bytes(2, "little")
                turn.play(partial(send, device, devices, frame), frames)
        results = {role: turn.results[1:] for role, (turn, _) in turns.items()}
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(summary(results), indent=2) + "\n")


def send(device: MockDevice, all_of_them: list[MockDevice], frame: bytearray, number: int) -> None:
    if number % 20 == 0:  # often enough; a thread of its own may not use the connections
        for each in all_of_them:
            each.wires["control"].send(Kind.PING)
    send_frame(device, frame, number)


def summary(results: dict[str, list[tuple[float, float]]]) -> dict[str, float]:
    """From (CPU ms per frame, frames per s) of each repetition."""
    found: dict[str, float] = {}
    for role, turns in results.items():
        cpu_ms, rate = (statistics.median(column) for column in zip(*turns, strict=True))
        found |= {
            f"{role}_cpu_ms_per_frame": cpu_ms,
            f"{role}_frames_per_s": rate,
            f"{role}_gbit_per_s": rate * (HEADER_BYTES + len(PAYLOAD)) * 8e-9,
        }
    ratios = [tls[0] / plain[0] for plain, tls in zip(*results.values(), strict=True)]
    return found | {
        "cpu_ratio": statistics.median(ratios),
        "frame_bytes": HEADER_BYTES + len(PAYLOAD),
        "frames": FRAMES,
        "repetitions": REPETITIONS,
    }


def play(role: str, keys: str) -> None:
    """A receiver without ROS."""
    server = Server(
        listen(("127.0.0.1", 0)),
        load_table(),
        REQUEST,
        PrintedEvents(),
        access=PairedOnly(Path(keys)) if role == "tls" else Everybody(),
        name="bench",
        software="bench",
    )
    print(server.address, flush=True)
    answer(lambda: received(server))
    server.stop()


if __name__ == "__main__":
    if len(sys.argv) > 1:
        play(*sys.argv[1:])
    else:
        main()

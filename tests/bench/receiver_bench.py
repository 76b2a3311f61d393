"""Compares the receiver with a bare loop of recv_into and raw publish, in alternation.

Usage: receiver_bench.py RESULTS FRAMES REPETITIONS. With PEER=<checkout of ROS-TCP-Endpoint> in the
environment, ROS-TCP-Endpoint is measured, too. All get the same bytes and publish through rclpy
with the same Fast DDS profile, in their own processes, to one subscriber that takes bytes. CPU is
that of the whole receiving process by getrusage. Results are medians of the repetitions.
"""

import json
import os
import socket
import statistics
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from endpoint import connect, message, registration
from frames import BARE_TOPIC, DEPTH, ENDPOINT_TOPIC, IMAGE, IMAGE_PAYLOAD, RECEIVER_TOPIC, sender
from ml2_receiver.wire.frame import HEADER_BYTES
from mock_device import MockDevice
from players import Player, Turn, Usage

WARM_UP_FRAMES = 100
_NO_PEER = "not compared; make bench PEER=<checkout of ROS-TCP-Endpoint>"


def main(results_file: Path, frames: int, repetitions: int) -> None:
    peer = os.environ.get("PEER")
    with ExitStack() as stack:
        turns = own_turns(stack)
        if peer:
            turns["endpoint"] = endpoint_turn(stack, peer)
        for turn, send in turns.values():
            turn.play(send, min(frames, WARM_UP_FRAMES))
            turn.results.clear()
        for _ in range(repetitions):
            for turn, send in turns.values():
                turn.play(send, frames)
    results = summary({name: turn for name, (turn, _) in turns.items()})
    results |= {} if peer else {"endpoint": _NO_PEER}
    results |= {
        "frame_bytes": HEADER_BYTES + len(IMAGE_PAYLOAD),
        "frames": frames,
        "repetitions": repetitions,
    }
    results_file.parent.mkdir(parents=True, exist_ok=True)
    results_file.write_text(json.dumps(results, indent=2) + "\n")


def own_turns(stack: ExitStack) -> dict[str, tuple[Turn, Callable[[], None]]]:
    """Returns the turns of the bare loop and of the receiver, which share a subscriber."""
    bare = stack.enter_context(Player("bare"))
    receiver = stack.enter_context(Player("receiver"))
    device = stack.enter_context(MockDevice(receiver.line(), says_ping=True))
    device.start()
    host, _, port = bare.line().rpartition(":")
    bare_socket = stack.enter_context(socket.create_connection((host, int(port))))
    subscriber = stack.enter_context(Player("subscriber", IMAGE.type, RECEIVER_TOPIC, BARE_TOPIC))
    subscriber.line()
    return {
        "bare": (Turn(bare.usage), lambda: bare_socket.sendall(IMAGE_PAYLOAD)),
        "receiver": (Turn(receiver.usage), sender(device, IMAGE, IMAGE_PAYLOAD)),
    }


def endpoint_turn(stack: ExitStack, checkout: str) -> tuple[Turn, Callable[[], None]]:
    """Returns the turn of ROS-TCP-Endpoint; its frames are counted at the subscriber."""
    endpoint = stack.enter_context(Player("endpoint", checkout))
    connection = stack.enter_context(connect(endpoint.line()))
    connection.sendall(registration(ENDPOINT_TOPIC, IMAGE.type, DEPTH))
    subscriber = stack.enter_context(Player("subscriber", IMAGE.type, ENDPOINT_TOPIC))
    subscriber.line()
    frame = message(ENDPOINT_TOPIC, IMAGE_PAYLOAD)

    def usage(count: int) -> Usage:
        arrived = subscriber.usage(count).frames
        return endpoint.usage(0)._replace(frames=arrived)

    return Turn(usage), lambda: connection.sendall(frame)


def summary(turns: dict[str, Turn]) -> dict[str, object]:
    """Returns the medians, the receiver's first; a ratio is the median over the repetitions."""
    ours = turns["receiver"]
    results: dict[str, object] = {**medians("", ours)}
    for name, turn in turns.items():
        if turn is not ours:
            results |= medians(f"{name}_", turn)
            pairs = zip(ours.results, turn.results, strict=True)
            results[f"ratio_to_{name}"] = statistics.median(own[0] / its[0] for own, its in pairs)
    return results


def medians(prefix: str, turn: Turn) -> dict[str, float]:
    cpu_ms, rate = (statistics.median(column) for column in zip(*turn.results, strict=True))
    values = {"cpu_ms_per_frame": cpu_ms, "frames_per_s": rate, "lost": turn.lost}
    return {f"{prefix}{name}": value for name, value in values.items()}


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))

"""CPU of the receiver per frame, and per stream, with 0, 1 and 3 subscribers to that stream.

Usage: subscribers_bench.py FRAMES. Writes build/bench/subscribers.json: CPU ms per frame, of frames
that follow each other at once (median of the repetitions), and percent of one processor while they
come at the stream's rate, with all that the receiver does besides. Streams are an image of
1016 x 1016 and an IMU. Each subscriber is a process of its own that takes bytes.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from frames import IMAGE, IMAGE_PAYLOAD, IMU, IMU_PAYLOAD, PREFIX, sender
from ml2_receiver.table.stream_table import Topic
from mock_device import MockDevice
from players import Player, Turn

RESULTS = Path(__file__).resolve().parents[2] / "build" / "bench" / "subscribers.json"
SUBSCRIBERS = (0, 1, 3)
REPETITIONS = 5
PACED_S = 3
# As the stream table has them, and as Android's fastest IMU rate is.
STREAMS = {IMAGE: (IMAGE_PAYLOAD, 30), IMU: (IMU_PAYLOAD, 200)}


def main(frames: int) -> None:
    results = {topic.stream: measured(topic, *STREAMS[topic], frames) for topic in STREAMS}
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")


def measured(topic: Topic, payload: bytes, rate_hz: int, frames: int) -> dict[str, float]:
    """In a receiver of its own, with ever more subscribers."""
    results = {}
    with ExitStack() as stack:
        receiver = stack.enter_context(Player("receiver"))
        device = stack.enter_context(MockDevice(receiver.line(), says_ping=True))
        device.start()
        turn, send = Turn(receiver.usage), sender(device, topic, payload)
        present = 0
        for count in SUBSCRIBERS:
            while present < count:
                player = Player("subscriber", topic.type, topic.full_name(PREFIX))
                stack.enter_context(player).line()
                present += 1
            turn.results.clear()
            for _ in range(REPETITIONS):
                turn.play(send, frames)
            cpu_ms = statistics.median(cpu_ms for cpu_ms, _ in turn.results)
            turn.play(paced(send, rate_hz), PACED_S * rate_hz)
            paced_cpu_ms, _ = turn.results[-1]
            results[f"{count}_subscribers_cpu_ms_per_frame"] = cpu_ms
            results[f"{count}_subscribers_cpu_percent"] = paced_cpu_ms * rate_hz / 10
    return results


def paced(send: Callable[[], None], rate_hz: int) -> Callable[[], None]:
    def send_and_wait() -> None:
        send()
        time.sleep(1 / rate_hz)

    return send_and_wait


if __name__ == "__main__":
    main(int(sys.argv[1]))

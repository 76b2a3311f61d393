"""Measures the receiver's CPU time with 0, 1 and 3 subscribers to a stream.

Usage: subscribers_bench.py FRAMES. Writes build/bench/subscribers.json for an image of 1016 x 1016
and an IMU:
- CPU ms per frame, while frames are sent as fast as possible (median of the repetitions)
- percent of one processor, while frames are sent at the stream's rate; this includes all other
  work of the receiver
Each subscriber is a separate process that takes bytes.
"""

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
# Payload and rate in Hz: the image's rate in the stream table, and Android's fastest IMU rate.
STREAMS = {IMAGE: (IMAGE_PAYLOAD, 30), IMU: (IMU_PAYLOAD, 200)}


def main(frames: int) -> None:
    results = {topic.stream: measured(topic, *STREAMS[topic], frames) for topic in STREAMS}
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")


def measured(topic: Topic, payload: bytes, rate_hz: int, frames: int) -> dict[str, float]:
    """Measures one stream in a new receiver, while the number of subscribers increases."""
    results = {}
    with ExitStack() as stack:
        receiver = stack.enter_context(Player("receiver"))
        device = stack.enter_context(MockDevice(receiver.line(), says_ping=True))
        device.start()
        turn, send = Turn(receiver.usage), sender(device, topic, payload)
        subscribers = 0
        for count in SUBSCRIBERS:
            while subscribers < count:
                player = Player("subscriber", topic.type, topic.full_name(PREFIX))
                stack.enter_context(player).line()
                subscribers += 1
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

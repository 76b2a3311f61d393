"""A subscriber in a process of its own that keeps the payloads of given topics.

Usage: products_subscriber.py TOPICS COUNT OUTPUT. TOPICS is JSON, types by full topic name. Once
the receiver has topics it lets the headset start; when each topic has brought COUNT messages, or
after its patience, it pickles {topic: (type, [payload, ...])}.
"""

from __future__ import annotations

import json
import pickle
import sys
import threading
import time
from pathlib import Path

import rclpy
from std_srvs.srv import Trigger

from ml2_receiver.raw_taker import RawSubscription, RawTaker

_PATIENCE_S = 30.0


def main(types: dict[str, str], count: int, output: Path) -> None:
    rclpy.init()
    node = rclpy.create_node("products_subscriber")
    taken: dict[str, list[bytes]] = {topic: [] for topic in types}
    taker = RawTaker(
        node,
        [RawSubscription(type, topic, 1000, taken[topic].append) for topic, type in types.items()],
    )
    print("subscribed", flush=True)
    start = rclpy.create_node("products_starter")
    client = start.create_client(Trigger, "/ml2_receiver/start")
    deadline_s = time.monotonic() + _PATIENCE_S
    client.wait_for_service(_PATIENCE_S)
    while not all(node.count_publishers(topic) for topic in types):
        if time.monotonic() > deadline_s:
            break
        rclpy.spin_once(start, timeout_sec=0.1)
    rclpy.spin_until_future_complete(start, client.call_async(Trigger.Request()), timeout_sec=10)
    pause = threading.Event()
    while min(map(len, taken.values())) < count and time.monotonic() < deadline_s:
        pause.wait(0.1)
    taker.stop()
    output.write_bytes(pickle.dumps({name: (types[name], taken[name]) for name in types}))
    rclpy.shutdown()


if __name__ == "__main__":
    main(json.loads(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))

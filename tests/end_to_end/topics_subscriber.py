"""Runs a subscriber in its own process that keeps the payloads of given topics.

Usage: topics_subscriber.py TOPICS COUNT OUTPUT. TOPICS is JSON: message types by full topic name.
When each topic has COUNT messages, or after a timeout, it pickles {topic: (type, [payload, ...])}
to OUTPUT.
"""

from __future__ import annotations

import json
import pickle
import sys
import threading
import time
from pathlib import Path

import rclpy
from rclpy.qos import QoSProfile

from ml2_receiver.ros.context import end_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_tools.live.faults import Faults
from waiting import LIMIT_S

_POLL_S = 0.1
_DEPTH = 1000


def main(types: dict[str, str], count: int, output: Path) -> None:
    rclpy.init()
    node = rclpy.create_node("topics_subscriber")
    taken: dict[str, list[bytes]] = {topic: [] for topic in types}
    subscriptions = [
        RawSubscription(type, topic, QoSProfile(depth=_DEPTH), taken[topic].append)
        for topic, type in types.items()
    ]
    taker = RawTaker(node, subscriptions, Faults().add)
    deadline_s = time.monotonic() + LIMIT_S
    pause = threading.Event()
    while min(map(len, taken.values())) < count and time.monotonic() < deadline_s:
        pause.wait(_POLL_S)
    taker.stop()
    output.write_bytes(pickle.dumps({name: (types[name], taken[name]) for name in types}))
    end_node(node)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))

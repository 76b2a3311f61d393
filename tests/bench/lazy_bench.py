"""Measures how fast a paused stream resumes, from a new subscription to its first image.

The simulated camera runs at 30 Hz, so up to 33 ms of each time are the wait for the
next capture. Writes build/bench/lazy_resume.json.
"""

import json
import os
import statistics
import subprocess
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import Image

from configurations import only

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "build" / "bench" / "lazy_resume.json"
CONFIG = only("world_left: {enabled: true}, publish: {lazy: true}")
TOPIC = "/magic_leap2/world_left/image_raw"
REPETITIONS = 15
_PAUSE_S = 1.0
_TIMEOUT_S = 30.0


def main() -> None:
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        (folder / "config.yaml").write_text(CONFIG)
        config = ["--config", str(folder / "config.yaml"), "--listen", "127.0.0.1:0", "--insecure"]
        receiver = subprocess.Popen(
            [str(ROOT / "host_receiver/ml2-receiver"), "run", *config],
            stdout=subprocess.PIPE,
            text=True,
        )
        stack.callback(receiver.terminate)
        assert receiver.stdout is not None
        address = receiver.stdout.readline().split()[-1]
        headset = str(ROOT / "ml2-sensors-aar/simulator/ml2-headset")
        still = ["--simulate", "still_images=1"]
        send = [headset, "--insecure", "--receiver", address, *still]
        stack.callback(subprocess.Popen(send).terminate)
        rclpy.init()
        stack.callback(rclpy.shutdown)
        node = rclpy.create_node("lazy_bench")
        await_image(node)  # the headset draws its scene before the first image
        times_ms = []
        for _ in range(REPETITIONS):
            time.sleep(_PAUSE_S)
            times_ms.append(await_image(node) * 1000)
    result = {
        "resume_ms_median": statistics.median(times_ms),
        "resume_ms_max": max(times_ms),
        "repetitions": len(times_ms),
    }
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(result, indent=2) + "\n")
    print(json.dumps(result))


def await_image(node: Node) -> float:
    """Subscribes, waits for an image and unsubscribes; returns the seconds until the image."""
    arrived: list[bytes] = []
    began_s = time.monotonic()
    subscription = node.create_subscription(
        Image, TOPIC, arrived.append, qos_profile_sensor_data, raw=True
    )
    while not arrived:
        rclpy.spin_once(node, timeout_sec=0.1)
        assert time.monotonic() - began_s < _TIMEOUT_S, "no image arrived"
    node.destroy_subscription(subscription)
    return time.monotonic() - began_s


if __name__ == "__main__":
    main()

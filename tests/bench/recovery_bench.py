"""Measures how fast headset and receiver connect, and reconnect after a fault.

Usage: recovery_bench.py RUNS. Writes build/bench/recovery.json, in seconds, for RUNS runs each:

find                a headset starts to search for a receiver's name -> connected
late_receiver       the receiver starts to listen while a headset searches for it -> connected
restart_by_name     a killed receiver listens again on another port -> connected
restart_at_address  the same on the same port, with a headset that got the address
cut_link            all connections are closed -> the next IMU message at a subscriber
will_of_silent_link the link stands still -> the will of an app at a subscriber, after its 300 ms
will_of_killed_app  the same, after the app is killed; below 0 before its 300 ms

Down times are random, to cover every phase of the headset's pauses and searches. A time starts when
the receiver prints that it listens, so its start-up is not included. The headset plays test
signals.
"""

import contextlib
import json
import os
import queue
import random
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import Imu

from configurations import only
from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from processes import (
    ON_LOOPBACK,
    PREFIX,
    ROOT,
    headset_command,
    isolated_environment,
    line_with,
    listening_address,
    process,
    receive_command,
)
from proxy import Proxy

type Child = subprocess.Popen[str]

RESULTS = ROOT / "build" / "bench" / "recovery.json"
CONFIG = only(
    "other_sensors: {enabled: true}, custom: {enabled: true}, app: {publish: [/bench/command]}"
)
COMMAND, COMMAND_TYPE, WILL_S = "/bench/command", "std_msgs/msg/UInt8MultiArray", 0.3
# A command has 8 bytes after an encapsulation, a layout without dimensions, offset and length.
WILL_BYTES = 4 + 4 + 4 + 4 + 8
NAME = f"bench{os.getpid()}"
TOPIC = f"/{NAME}{PREFIX}/gyro_left/imu"
ANYWHERE = "127.0.0.1:0"
LONGEST_DOWN_S = 3.0
_TIMEOUT_S = 30.0

moments = random.Random(1)


def main(runs: int) -> None:
    environment = isolated_environment()
    os.environ.update(environment)
    with tempfile.TemporaryDirectory(prefix="ml2_recovery") as name:
        bench = Bench(Path(name), environment)
        results: dict[str, Any] = {"runs": runs}
        for measure in MEASURES:
            times_s = list(measure(bench, runs))
            results[measure.__name__] = {
                "median_s": statistics.median(times_s),
                "max_s": max(times_s),
            }
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")


class Bench:
    """The receiver and headset processes in one ROS domain; logs are in `folder`."""

    def __init__(self, folder: Path, environment: dict[str, str]) -> None:
        self._folder, self._environment = folder, environment | ON_LOOPBACK
        self._config = folder / "config.yaml"
        self._config.write_text(CONFIG)

    def receiver(
        self, address: str = ANYWHERE, *options: str
    ) -> contextlib.AbstractContextManager[Child]:
        command = receive_command(self._config, address, "--name", NAME, *options)
        return process(command, self._environment, self._folder / "receiver.log")

    def headset(
        self, receiver: str = NAME, *options: str
    ) -> contextlib.AbstractContextManager[Child]:
        command = headset_command(receiver, *options)
        return process(command, self._environment, self._folder / "headset.log")


def find(bench: Bench, runs: int) -> Iterator[float]:
    with bench.receiver() as receiver:
        listening_address(receiver)
        for _ in range(runs):
            with bench.headset() as headset:
                line_with(headset, "connecting to")
                yield until_connected(headset)


def late_receiver(bench: Bench, runs: int) -> Iterator[float]:
    for _ in range(runs):
        with bench.headset() as headset:
            line_with(headset, "connecting to")
            be_down()
            with bench.receiver() as receiver:
                listening_address(receiver)
                yield until_connected(headset)


def restart_by_name(bench: Bench, runs: int) -> Iterator[float]:
    with bench.headset() as headset:
        yield from restarts(bench, runs, headset, ANYWHERE)


def restart_at_address(bench: Bench, runs: int) -> Iterator[float]:
    with bench.receiver() as receiver:
        address = listening_address(receiver)
    with bench.headset(address) as headset:
        yield from restarts(bench, runs, headset, address)


def restarts(bench: Bench, runs: int, headset: Child, address: str) -> Iterator[float]:
    for run in range(1 + runs):
        with bench.receiver(address) as receiver:
            listening_address(receiver)
            time_s = until_connected(headset)
            if run:
                yield time_s
            receiver.kill()
        be_down()


def cut_link(bench: Bench, runs: int) -> Iterator[float]:
    rclpy.init()
    node = rclpy.create_node("recovery_bench")
    stamps_ns: list[int] = []

    def take(message: Imu) -> None:
        stamps_ns.append(Time.from_msg(message.header.stamp).nanoseconds)

    node.create_subscription(Imu, TOPIC, take, qos_profile_sensor_data)
    with (
        bench.receiver() as receiver,
        Proxy(listening_address(receiver)) as proxy,
        bench.headset(proxy.address),
    ):
        await_message(node, stamps_ns, 0)
        for _ in range(runs):
            proxy.cut()
            yield await_message(node, stamps_ns, time.time_ns())
    node.destroy_node()
    rclpy.shutdown()


def will_of_silent_link(bench: Bench, runs: int) -> Iterator[float]:
    yield from wills(bench, runs, lambda proxy, _: proxy.take_down())


def will_of_killed_app(bench: Bench, runs: int) -> Iterator[float]:
    yield from wills(bench, runs, lambda _, headset: headset.kill())


def wills(bench: Bench, runs: int, end: Callable[[Proxy, Child], None]) -> Iterator[float]:
    """From the last command at a subscriber, and the silence after it, to the will there."""
    arrivals: queue.Queue[tuple[float, bool]] = queue.Queue()
    publish = "--publish", COMMAND, "8", "50", f"{WILL_S * 1000:.0f}"

    def take(payload: bytes) -> None:
        arrivals.put((time.monotonic(), len(payload) < WILL_BYTES))

    subscription = RawSubscription(COMMAND_TYPE, COMMAND, QoSProfile(depth=100), take)
    for _ in range(runs):
        with (
            tool_node("recovery_bench") as node,
            bench.receiver(ANYWHERE, "--insecure-control") as receiver,
            Proxy(listening_address(receiver)) as proxy,
            bench.headset(proxy.address, *publish) as headset,
        ):
            taker = RawTaker(node, [subscription], lambda _, error: None)
            last_s, is_will = arrivals.get(timeout=_TIMEOUT_S)
            end(proxy, headset)
            while not is_will:
                before_s = last_s
                last_s, is_will = arrivals.get(timeout=_TIMEOUT_S)
            taker.stop()
            yield last_s - before_s - WILL_S


def await_message(node: Node, stamps_ns: list[int], after_ns: int) -> float:
    """Waits for a message that was captured after `after_ns`; returns the seconds it took."""
    began_s = time.monotonic()
    while not stamps_ns or stamps_ns[-1] <= after_ns:
        rclpy.spin_once(node, timeout_sec=0.1)
        assert time.monotonic() - began_s < _TIMEOUT_S, "no message arrived"
    return time.monotonic() - began_s


def until_connected(headset: Child) -> float:
    """Waits until the headset is connected; returns the seconds it took."""
    began_s = time.monotonic()
    line_with(headset, "connected to")
    return time.monotonic() - began_s


def be_down() -> None:
    time.sleep(moments.uniform(0, LONGEST_DOWN_S))


MEASURES = (
    *(find, late_receiver, restart_by_name, restart_at_address, cut_link),
    *(will_of_silent_link, will_of_killed_app),
)

if __name__ == "__main__":
    main(int(sys.argv[1]))

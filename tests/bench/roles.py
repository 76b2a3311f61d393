"""The roles of a Player process.

Usage: roles.py ROLE [ARGUMENT...]. The process first prints that it is ready; a publisher prints
the address to send to. Each line of standard input is a number of frames: the process waits for as
many, and prints its CPU time in s, its wall time in s and the number of frames. All roles use the
same Fast DDS profile.
"""

import json
import os
import resource
import socket
import sys
import threading
import time
from array import array
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from endpoint import start_endpoint
from frames import BARE_TOPIC, CONFIG, DEPTH, IMAGE_PAYLOAD, REQUEST
from ml2_receiver.commands.printed_events import PrintedEvents
from ml2_receiver.configuration.config import parse_config
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.ros.fastdds import apply_default_profile
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import ReceiverSettings
from ml2_receiver.session.sink import Sink
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.topics.message_types import message_class
from ml2_receiver.transport.access import Access, Everybody, PairedOnly
from ml2_receiver.transport.listener import listen

_POLL_S = 0.001
_QUIET_S = 5.0
_TIMEOUT_S = 20.0


def play_receiver() -> None:
    """Runs the sockets and the ROS node of `ml2-receiver run`."""
    from ml2_receiver.ros.node import RosNode
    from ml2_receiver.ros.sink import RosSink

    sinks = FanOut([])
    server = bench_server(sinks, Everybody())
    with (
        RosNode(parse_config(CONFIG), []) as node,
        RosSink(node, server, ConfigFile(Path("bench.yaml")), lambda _: None, sinks),
    ):
        receive(server)


def play_session(keys: str = "") -> None:
    """Runs a receiver without ROS, for the device paired in the folder `keys`, or in plaintext."""
    receive(bench_server(PrintedEvents(), PairedOnly(Path(keys)) if keys else Everybody()))


def bench_server(sink: Sink, access: Access) -> Server:
    return Server(
        listen(("127.0.0.1", 0)),
        access,
        sink,
        REQUEST,
        ReceiverSettings("bench", "bench"),
    )


def receive(server: Server) -> None:
    server.start()
    print(server.address, flush=True)
    answer(lambda: received(server))
    server.stop()


def received(server: Server) -> int:
    report = server.report()
    return sum(row.statistics.received for row in report.topics) if report else 0


def play_bare() -> None:
    """Runs the smallest receiver in Python: a loop of recv_into and publish."""
    import rclpy
    from sensor_msgs.msg import Image

    rclpy.init()
    node = rclpy.create_node("bare")
    publish = node.create_publisher(Image, BARE_TOPIC, DEPTH).handle.publish_raw
    listener = listen(("127.0.0.1", 0))
    print("{}:{}".format(*listener.getsockname()), flush=True)
    connection, _ = listener.accept()
    published = 0

    def loop() -> None:
        nonlocal published
        payload = bytearray(len(IMAGE_PAYLOAD))
        while connection.recv_into(payload, 0, socket.MSG_WAITALL):
            publish(payload)
            published += 1

    threading.Thread(target=loop, daemon=True).start()
    answer(lambda: published)
    rclpy.shutdown()


def play_subscriber(type: str, counted: str, *others: str) -> None:
    """Waits until all topics have publishers, takes their bytes and counts the first topic's."""
    import rclpy
    from rclpy.executors import ExternalShutdownException

    rclpy.init()
    node = rclpy.create_node(f"subscriber{os.getpid()}")
    arrived = 0

    def count(_: Any) -> None:
        nonlocal arrived
        arrived += 1

    def serve() -> None:
        answer(lambda: arrived)
        rclpy.shutdown()

    message = message_class(type)
    node.create_subscription(message, counted, count, DEPTH, raw=True)
    for topic in others:
        node.create_subscription(message, topic, lambda _: None, DEPTH, raw=True)
    deadline_s = time.monotonic() + _TIMEOUT_S
    while not all(node.count_publishers(topic) for topic in (counted, *others)):
        rclpy.spin_once(node, timeout_sec=0.1)
        if time.monotonic() > deadline_s:
            raise SystemExit(f"{counted} has no publisher after {_TIMEOUT_S:g} s")
    print("ready", flush=True)
    threading.Thread(target=serve).start()
    with suppress(ExternalShutdownException):
        rclpy.spin(node)


def play_publisher(topic: str, rate_hz: str, length: str = "") -> None:
    """Publishes, for each line of standard input, so many messages at a rate.

    They are texts of 100 bytes, or so many bytes. They begin with the time of their publication in
    ns, by CLOCK_MONOTONIC, in 20 digits. It first waits for a subscriber.
    """
    import rclpy
    from rclpy.qos import QoSProfile
    from std_msgs.msg import String, UInt8MultiArray

    rclpy.init()
    node = rclpy.create_node("publisher")
    large = UInt8MultiArray(data=bytes(int(length))) if length else None
    publisher = node.create_publisher(
        type(large) if large else String, topic, QoSProfile(depth=100)
    )
    while not publisher.get_subscription_count():
        time.sleep(_POLL_S)
    print("ready", flush=True)
    # The encapsulation, the length and the last byte of a String are the other 9 bytes
    padding, period_s = "x" * (100 - 9 - 20), 1 / float(rate_hz)
    for line in sys.stdin:
        begin_s = time.monotonic()
        for number in range(int(line)):
            time.sleep(max(0.0, begin_s + number * period_s - time.monotonic()))
            stamp = f"{time.monotonic_ns():020}"
            if large is None:
                publisher.publish(String(data=stamp + padding))
            else:
                large.data[: len(stamp)] = array("B", stamp.encode())
                publisher.publish(large)
        print_usage(int(line))
    rclpy.shutdown()


def play_ages(topic: str, type: str) -> None:
    """Answers each line of standard input with the ages of the messages since the line before.

    They are in ms, from the stamp of the header to this process.
    """
    import rclpy
    from rclpy.qos import qos_profile_sensor_data

    from ml2_receiver.topics.stamps import stamp_reader

    rclpy.init()
    node = rclpy.create_node("ages")
    read, ages_ms = stamp_reader(type), list[float]()

    def take(payload: bytes) -> None:
        ages_ms.append((time.time_ns() - read(payload)) / 1e6)

    node.create_subscription(message_class(type), topic, take, qos_profile_sensor_data, raw=True)
    threading.Thread(target=rclpy.spin, args=[node], daemon=True).start()
    print("ready", flush=True)
    for _ in sys.stdin:
        found, ages_ms[:] = list(ages_ms), []
        print(json.dumps(found), flush=True)
    os._exit(0)


def answer(count: Callable[[], int]) -> None:
    """Answers each line of standard input until its end.

    Stops waiting for frames, which are then lost, when none arrives for _QUIET_S.
    """
    for line in sys.stdin:
        counted, changed_s = count(), time.monotonic()
        while counted < int(line) and time.monotonic() - changed_s < _QUIET_S:
            time.sleep(_POLL_S)
            if count() > counted:
                counted, changed_s = count(), time.monotonic()
        print_usage(counted)


def print_usage(frames: int) -> None:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    cpu_s = usage.ru_utime + usage.ru_stime
    print(json.dumps([cpu_s, time.monotonic(), frames]), flush=True)


def main(role: str, *arguments: str) -> None:
    apply_default_profile(os.environ, sends_images=True)
    match role:
        case "receiver":
            play_receiver()
        case "session":
            play_session(*arguments)
        case "bare":
            play_bare()
        case "subscriber":
            play_subscriber(*arguments)
        case "publisher":
            play_publisher(*arguments)
        case "ages":
            play_ages(*arguments)
        case "endpoint":
            print(start_endpoint(Path(*arguments)), flush=True)
            answer(lambda: 0)
            os._exit(0)  # its threads do not end


if __name__ == "__main__":
    main(*sys.argv[1:])

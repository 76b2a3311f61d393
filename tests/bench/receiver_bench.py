"""The receiver beside a bare loop of recv_into and raw publish: the same bytes, in turns.

Both publish through rclpy with the same Fast DDS profile, in processes of their own, to one
subscriber that takes bytes. CPU is that of the whole receiving process, as getrusage tells.
Results are medians of the repetitions.
"""

from __future__ import annotations

import json
import os
import resource
import socket
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

from ml2_receiver.configuration.config import parse_config
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.configuration.table import load_table
from ml2_receiver.fastdds import apply_default_profile
from ml2_receiver.link.access import Everybody
from ml2_receiver.link.listener import listen
from ml2_receiver.link.server import Server
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, HEADER_BYTES, Kind, encode_frame
from mock_device import MockDevice

RESULTS = Path(__file__).resolve().parents[2] / "build" / "bench" / "receiver.json"
TOPIC = load_table().streams["world_left"].topics[0]
CONFIG = b"/**: {ros__parameters: {general: {topic_name: bench}}}"
REQUEST = {"world_left": {"stream": 0}}
RECEIVER_TOPIC, BARE_TOPIC = f"/bench/{TOPIC.name}", "/bench/bare"
# As large as a sensor_msgs/Image of 1016 x 1016 mono8; nobody decodes it.
PAYLOAD = CDR_ENCAPSULATION + os.urandom(1016 * 1016 + 64)
WARM_UP_FRAMES = 100
FRAMES = 500
REPETITIONS = 7
_POLL_S = 0.001
_SEQUENCE_OFFSET = 8


def main() -> None:
    """Runs the turns and writes build/bench/receiver.json."""
    with ExitStack() as stack:
        bare = stack.enter_context(Player("bare"))
        receiver = stack.enter_context(Player("receiver"))
        device = stack.enter_context(MockDevice(receiver.line(), says_ping=True))
        device.start()
        host, _, port = bare.line().rpartition(":")
        bare_socket = stack.enter_context(socket.create_connection((host, int(port))))
        subscriber = stack.enter_context(Player("subscriber"))
        subscriber.line()

        channel = device.channels[TOPIC.name][0]
        frame = bytearray(encode_frame(Kind.DATA, PAYLOAD, channel=channel))
        turns = [
            (Turn(bare), lambda _: bare_socket.sendall(PAYLOAD)),
            (Turn(receiver), lambda number: send_frame(device, frame, number)),
        ]
        for turn, send in turns:
            turn.play(send, WARM_UP_FRAMES)
            turn.results.clear()
        for _ in range(REPETITIONS):
            for turn, send in turns:
                turn.play(send, FRAMES)
        device.leave()
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(summary(*(turn.results for turn, _ in turns)), indent=2) + "\n")


def send_frame(device: MockDevice, frame: bytearray, number: int) -> None:
    frame[_SEQUENCE_OFFSET : _SEQUENCE_OFFSET + 4] = number.to_bytes(4, "little")
    device.wires[TOPIC.lane].socket.sendall(frame)


def summary(
    bare: list[tuple[float, float]], receiver: list[tuple[float, float]]
) -> dict[str, float]:
    """From (CPU ms per frame, frames per s) of each repetition."""
    bare_cpu_ms, bare_rate = (statistics.median(column) for column in zip(*bare, strict=True))
    cpu_ms, rate = (statistics.median(column) for column in zip(*receiver, strict=True))
    return {
        "cpu_ms_per_frame": cpu_ms,
        "frames_per_s": rate,
        "bare_cpu_ms_per_frame": bare_cpu_ms,
        "bare_frames_per_s": bare_rate,
        "ratio_to_bare": statistics.median(
            ours[0] / theirs[0] for ours, theirs in zip(receiver, bare, strict=True)
        ),
        "frame_bytes": HEADER_BYTES + len(PAYLOAD),
        "frames": FRAMES,
        "repetitions": REPETITIONS,
    }


class Player:
    """A script, this one unless said otherwise, in a process of its own with another role."""

    def __init__(self, role: str, *arguments: str, script: str = __file__) -> None:
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(
            [sys.executable, script, role, *arguments], stdin=pipe, stdout=pipe, text=True
        )
        self.role = role

    def __enter__(self) -> Player:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate()

    def line(self) -> str:
        assert self._process.stdout is not None
        line = self._process.stdout.readline().strip()
        if not line:
            raise SystemExit(f"the {self.role} ended early")
        return line

    def usage(self, count: int) -> tuple[float, float]:
        """CPU and wall time in s, when `count` frames have been published."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{count}\n")
        self._process.stdin.flush()
        cpu_s, time_s = json.loads(self.line())
        return cpu_s, time_s


class Turn:
    """What one player has done."""

    def __init__(self, player: Player) -> None:
        self.results: list[tuple[float, float]] = []
        self._player = player
        self._sent = 0

    def play(self, send: Callable[[int], None], frames: int) -> None:
        """Sends as fast as they are taken."""
        began_cpu_s, began_s = self._player.usage(self._sent)
        for _ in range(frames):
            send(self._sent)
            self._sent += 1
        cpu_s, time_s = self._player.usage(self._sent)
        self.results.append(((cpu_s - began_cpu_s) * 1000 / frames, frames / (time_s - began_s)))


def play_receiver() -> None:
    """`ml2-receiver run` as far as sockets and ROS go."""
    from ml2_receiver.ros import RosNode

    node = RosNode(load_table(), parse_config(CONFIG), [])
    server = Server(
        listen(("127.0.0.1", 0)),
        load_table(),
        REQUEST,
        node,
        access=Everybody(),
        name="bench",
        software="bench",
    )
    node.serve(server, ConfigFile(Path("bench.yaml")))
    print(server.address, flush=True)
    answer(lambda: received(server))
    server.stop()
    node.close()


def received(server: Server) -> int:
    report = server.report()
    counts = {row.topic: row.statistics.received for row in report.topics} if report else {}
    return counts.get(TOPIC, 0)


def play_bare() -> None:
    """The least that Python can do."""
    import rclpy
    from sensor_msgs.msg import Image

    rclpy.init()
    node = rclpy.create_node("bare")
    publisher = node.create_publisher(Image, BARE_TOPIC, load_table().qos[TOPIC.qos].depth)
    publish = publisher.handle.publish_raw
    listener = listen(("127.0.0.1", 0))
    print("{}:{}".format(*listener.getsockname()), flush=True)
    connection, _ = listener.accept()
    count = 0

    def loop() -> None:
        nonlocal count
        payload = bytearray(len(PAYLOAD))
        while connection.recv_into(payload, 0, socket.MSG_WAITALL):
            publish(payload)
            count += 1

    threading.Thread(target=loop, daemon=True).start()
    answer(lambda: count)
    rclpy.shutdown()


def answer(published: Callable[[], int]) -> None:
    """Tells usage to who asks with the number of frames to wait for, until nobody does."""
    for line in sys.stdin:
        while published() < int(line):
            time.sleep(_POLL_S)
        usage = resource.getrusage(resource.RUSAGE_SELF)
        print(json.dumps([usage.ru_utime + usage.ru_stime, time.monotonic()]), flush=True)


def play_subscriber() -> None:
    """Takes the bytes of both, once matched."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from sensor_msgs.msg import Image

    rclpy.init()
    node = rclpy.create_node("subscriber")
    depth = load_table().qos[TOPIC.qos].depth

    def take(_: Any) -> None:
        pass

    for topic in (RECEIVER_TOPIC, BARE_TOPIC):
        node.create_subscription(Image, topic, take, depth, raw=True)
    while not all(node.count_publishers(topic) for topic in (RECEIVER_TOPIC, BARE_TOPIC)):
        rclpy.spin_once(node, timeout_sec=0.1)
    print("ready", flush=True)
    threading.Thread(target=end_with_input, args=[rclpy.shutdown]).start()
    with suppress(ExternalShutdownException):
        rclpy.spin(node)


def end_with_input(end: Callable[[], None]) -> None:
    sys.stdin.read()
    end()


if __name__ == "__main__":
    roles = {"receiver": play_receiver, "bare": play_bare, "subscriber": play_subscriber}
    if len(sys.argv) > 1:
        apply_default_profile(os.environ)
        roles[sys.argv[1]]()
    else:
        main()

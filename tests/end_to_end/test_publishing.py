"""The headset's app publishes: absolute names, latched and large topics, and wills."""

from __future__ import annotations

import hashlib
import itertools
import os
import queue
import struct
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from subprocess import Popen

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile

from configurations import only
from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from processes import (
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
)
from proxy import Proxy
from waiting import LIMIT_S, await_true

CONFIG = only("app: {publish: [/cmd]}, custom: {enabled: true}, other_sensors: {enabled: true}")
TYPE = "std_msgs/msg/UInt8MultiArray"
# An encapsulation, and a layout without dimensions and offset
HEAD_BYTES = 12
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
WILL_MS = 300


@pytest.fixture
def stack(monkeypatch: pytest.MonkeyPatch) -> Iterator[ExitStack]:
    for name, value in isolated_environment().items():
        monkeypatch.setenv(name, value)
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def receiver(stack: ExitStack, tmp_path: Path) -> Popen[str]:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG)
    command = receive_command(config, "127.0.0.1:0", "--insecure-control")
    return stack.enter_context(process(command, dict(os.environ), tmp_path / "receiver.log"))


def data(payload: bytes) -> bytes:
    (size,) = struct.unpack_from("<I", payload, HEAD_BYTES)
    begin = HEAD_BYTES + 4
    assert len(payload) >= begin + size
    return payload[begin : begin + size]


def heard(stack: ExitStack, topic: str, qos: QoSProfile) -> queue.Queue[bytes]:
    """Returns a queue of the data of a topic's messages."""
    messages: queue.Queue[bytes] = queue.Queue()
    subscription = RawSubscription(TYPE, topic, qos, lambda it: messages.put(data(it)))
    node = stack.enter_context(tool_node("listener"))
    taker = RawTaker(node, [subscription], lambda _, error: None)
    stack.callback(taker.stop)
    return messages


def publishing(stack: ExitStack, address: str, folder: Path, *options: str) -> Popen[str]:
    """Runs a headset that publishes; an option has its words with spaces between them."""
    words = [word for option in options for word in ("--publish", *option.split())]
    command = headset_command(address, *words)
    return stack.enter_context(process(command, dict(os.environ), folder / "headset.log"))


def published(headset: Popen[str], topic: str) -> Iterator[str]:
    """The SHA-256 of each message that the headset says it has published."""
    for line in lines(headset):
        if line.startswith(f"published {topic} "):
            yield line.split()[-1]


def test_names_need_a_rule_and_latched_messages_wait_for_their_subscriber(
    stack: ExitStack, receiver: Popen[str], tmp_path: Path
) -> None:
    heard_of_cmd = heard(stack, "/cmd", QoSProfile(depth=100))
    options = "/cmd 8 20 0", "/secret 8 20 0", "mode 8 0 0"
    headset = publishing(stack, listening_address(receiver), tmp_path, *options)
    refusal, mode = "", ""
    while not (refusal and mode):
        line = next(lines(headset))
        if line.startswith("not published: "):
            refusal = line
        if line.startswith("published mode "):
            mode = line.split()[-1]
    assert refusal == "not published: /secret: no rule in app.publish has /secret\n"
    late = heard(stack, "/magic_leap2/custom/mode", LATCHED)
    assert hashlib.sha256(late.get(timeout=LIMIT_S)).hexdigest() == mode
    assert len(heard_of_cmd.get(timeout=LIMIT_S)) == 8


def test_messages_of_megabytes_arrive_as_they_were_published_beside_sensors(
    stack: ExitStack, receiver: Popen[str], tmp_path: Path
) -> None:
    maps = heard(stack, "/magic_leap2/custom/map", QoSProfile(depth=10))
    imu: queue.Queue[bytes] = queue.Queue()
    sensor = RawSubscription(
        "sensor_msgs/msg/Imu", "/magic_leap2/accel_left/imu", QoSProfile(depth=10), imu.put
    )
    node = stack.enter_context(tool_node("imu"))
    stack.callback(RawTaker(node, [sensor], lambda _, error: None).stop)
    headset = publishing(stack, listening_address(receiver), tmp_path, "map 8000000 2 0")
    sent = published(headset, "map")
    hashes = [next(sent)]
    for _ in range(3):
        hash = hashlib.sha256(maps.get(timeout=LIMIT_S)).hexdigest()
        while hash not in hashes:
            hashes.append(next(sent))
        imu.get(timeout=LIMIT_S)


@pytest.mark.parametrize("ending", ["link", "app"])
def test_the_will_is_the_last_word_once_when_the_link_is_down_or_the_app_is_killed(
    stack: ExitStack, receiver: Popen[str], tmp_path: Path, ending: str
) -> None:
    commands = heard(stack, "/cmd", QoSProfile(depth=100))
    proxy = stack.enter_context(Proxy(listening_address(receiver)))
    headset = publishing(stack, proxy.address, tmp_path, f"/cmd 8 50 {WILL_MS}")
    assert len(commands.get(timeout=LIMIT_S)) == 8
    if ending == "link":
        proxy.take_down()
    else:
        headset.kill()
    words: list[bytes] = []

    def last_word() -> bytes | None:
        while not commands.empty():
            words.append(commands.get())
        return words[-1] if words else None

    await_true(lambda: last_word() == b"")
    await_true(lambda: "its will is published" in (tmp_path / "receiver.log").read_text())
    # Ends the session and its lanes, after which nothing can come any more
    receiver.terminate()
    receiver.communicate(timeout=LIMIT_S)
    await_true(lambda: last_word() == b"")
    # A busy app may have fallen silent before, and spoken again.
    assert (b"", b"") not in itertools.pairwise(words)

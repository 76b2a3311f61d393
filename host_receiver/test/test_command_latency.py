import signal
import struct
import threading
import time
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

import pytest

from command_line import refusal
from mock_device import MockDevice
from repeated import repeated
from ros_processes import Child
from waiting import LIMIT_S, await_true

pytest.importorskip("rclpy", reason="rclpy is not installed")

from rclpy.node import Node

from configurations import only
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_tools.monitoring import latency_node

MS = 1_000_000
CONFIG = only("battery: {enabled: true}")


def publishing(device: MockDevice) -> AbstractContextManager[None]:
    """Messages captured 50 ms and sent 20 ms ago, with such a stamp."""

    def publish() -> None:
        now_ns = time.time_ns()
        capture_ns = now_ns - 50 * MS
        stamp = struct.pack("<iI", *divmod(capture_ns, 1000 * MS))
        payload = b"\x00\x01\x00\x00" + stamp + bytes(100)
        device.publish("battery", payload, capture_ns=capture_ns, send_ns=now_ns - 20 * MS)

    return repeated(publish, 0.02)


def latency(*options: str) -> Child:
    return Child("-m", "ml2_receiver", "latency", *options)


def cells(child: Child) -> list[str]:
    """Returns the cells of the row of the battery."""
    while True:
        found = child.line().split()
        if found[:1] == ["battery"]:
            return found


def test_it_shows_where_the_time_goes(device: MockDevice) -> None:
    began_s = time.monotonic()
    with publishing(device), latency("--once", "--duration", "1") as child:
        _, messages, *figures = cells(child)
        assert child.wait() == 0
        took_s = time.monotonic() - began_s
    sent, received, published, subscriber, mean, p50, p99, jitter = map(float, figures)
    assert 1 <= int(messages) <= 50 * took_s
    assert sent == pytest.approx(30, abs=0.001)
    assert received >= 20
    assert min(published, subscriber, jitter) >= 0
    assert 50 <= p50 <= p99
    assert mean == pytest.approx(sent + received + published + subscriber, abs=0.003)


class EagerTaker(RawTaker):
    """Calls back before it is made."""

    def __init__(self, node: Node, subscriptions: list[RawSubscription], failed: Any) -> None:
        called = threading.Event()

        def call(payload: bytes) -> None:
            called.set()
            subscriptions[0].callback(payload)

        super().__init__(node, [replace(subscriptions[0], callback=call)], failed)
        assert called.wait(LIMIT_S)
        self._thread.join(0.2)  # time to fail in


@pytest.mark.usefixtures("ros_of_children", "device")
def test_a_receiver_may_speak_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(latency_node, "RawTaker", EagerTaker)
    node = latency_node.LatencyNode("", 1)
    try:
        await_true(lambda: "/magic_leap2/battery" in node.breakdowns())
    finally:
        node.close()


def test_without_once_it_measures_until_it_is_interrupted(device: MockDevice) -> None:
    with publishing(device), latency() as child:
        assert child.line() == "measuring until Ctrl-C"
        child.process.send_signal(signal.SIGINT)
        assert int(cells(child)[1]) >= 1
        assert child.wait() == 0


@pytest.mark.usefixtures("receiver")
def test_without_a_headset_it_says_so() -> None:
    with latency("--once") as child:
        assert child.wait() == 2
        assert "the receiver has no headset" in "\n".join(child.errors)


@pytest.mark.parametrize("duration", ["0", "-1", "nan", "x", "3601"])
def test_a_duration_is_some_seconds(duration: str) -> None:
    assert f"expected 1 to 3600 seconds, found {duration!r}" in refusal(
        "latency", "--duration", duration
    )

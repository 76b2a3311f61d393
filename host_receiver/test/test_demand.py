"""Streams whose subscribers come and go, by a manual clock."""

from itertools import pairwise

from fake_sink import FakeSink
from ml2_receiver.session.demand import STAYS_S, Demand
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import ReceiverSettings
from ml2_receiver.session.streams import Request
from ml2_receiver.transport.access import Everybody
from ml2_receiver.transport.listener import listen
from mock_device import MockDevice

LEFT, RIGHT = "world_left", "world_right"


class Subscribers:
    def __init__(self, *idle: str) -> None:
        self.idle = set(idle)

    def __call__(self) -> set[str]:
        return set(self.idle)


def test_a_stream_that_a_subscriber_started_runs_on_for_some_seconds() -> None:
    subscribers = Subscribers(LEFT, RIGHT)
    demand = Demand(subscribers)
    assert demand.idle_streams(0.0) == {LEFT, RIGHT}
    subscribers.idle = {RIGHT}
    assert demand.idle_streams(1.0) == {RIGHT}
    subscribers.idle = {LEFT, RIGHT}
    assert demand.idle_streams(100.0) == {RIGHT}
    assert not demand.is_due(100.0 + STAYS_S - 0.01)
    assert demand.idle_streams(100.0 + STAYS_S - 0.01) == {RIGHT}
    assert demand.is_due(100.0 + STAYS_S)
    assert demand.idle_streams(100.0 + STAYS_S) == {LEFT, RIGHT}
    assert not demand.is_due(1000.0)


def test_a_subscriber_in_a_loop_starts_a_camera_once() -> None:
    subscribers = Subscribers(LEFT)
    demand = Demand(subscribers)
    asked = [demand.idle_streams(0.0)]
    for step in range(1, 97):  # in 6 s
        subscribers.idle ^= {LEFT}
        asked.append(demand.idle_streams(step / 16))
    assert sum(one != other for one, other in pairwise(asked)) == 1


def test_slower_ones_start_it_at_most_once_in_that_time() -> None:
    subscribers = Subscribers(LEFT)
    demand = Demand(subscribers)
    changes_s, before = [], demand.idle_streams(0.0)
    for step in range(1, 6000):
        if step % 70 == 0:  # 7 s without, 0.1 s with
            subscribers.idle = set()
        elif step % 70 == 1:
            subscribers.idle = {LEFT}
        if (now := demand.idle_streams(step / 10)) != before:
            changes_s.append(step / 10)
            before = now
    starts_s = changes_s[::2]
    assert len(starts_s) > 50
    assert min(b - a for a, b in pairwise(starts_s)) > STAYS_S


def test_a_stream_that_ran_before_anybody_needed_it_ends_at_once() -> None:
    subscribers = Subscribers()
    demand = Demand(subscribers)
    assert demand.idle_streams(0.0) == set()
    subscribers.idle = {LEFT}
    assert demand.idle_streams(0.1) == {LEFT}


def test_a_stream_that_rests_again_stays_again_when_it_is_started_again() -> None:
    subscribers = Subscribers(LEFT)
    demand = Demand(subscribers)
    for begin_s in (0.0, 50.0):
        assert demand.idle_streams(begin_s) == {LEFT}
        subscribers.idle = set()
        demand.idle_streams(begin_s + 1)
        subscribers.idle = {LEFT}
        assert demand.idle_streams(begin_s + 2) == set()
        assert demand.idle_streams(begin_s + 2 + STAYS_S) == {LEFT}


def test_the_receiver_lets_a_camera_rest_without_another_event() -> None:
    subscribers = Subscribers(LEFT)
    request: Request = {LEFT: {"stream": 0, "format": "Grayscale"}, "tf": {"layout": "flat"}}
    server = Server(
        listen(("127.0.0.1", 0)),
        Everybody(),
        FakeSink(),
        request,
        ReceiverSettings("receiver", "test"),
        idle=subscribers,
    )
    try:
        with MockDevice(server.address, says_ping=True) as device:
            device.answer(device.reach_configure())
            asked = device.reconfigure()
            assert set(asked.streams) == {"tf"}
            device.expect_start(asked.request)
            subscribers.idle = set()
            server.update()
            asked = device.reconfigure()
            assert set(asked.streams) == {LEFT, "tf"}
            device.expect_start(asked.request)
            for idle in ({LEFT}, set(), {LEFT}, set(), {LEFT}):
                subscribers.idle = idle
                server.update()
            assert set(device.reconfigure().streams) == {"tf"}
    finally:
        server.stop()

"""Streams whose subscribers come and go, by a manual clock."""

from collections.abc import Mapping
from itertools import pairwise

from fake_sink import FakeSink
from ml2_receiver.session.demand import STAYS_S, Demand
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import ReceiverSettings
from ml2_receiver.session.streams import Request
from ml2_receiver.transport.access import Everybody
from ml2_receiver.transport.listener import listen
from mock_device import MockDevice
from scene import PATIENT

LEFT, RIGHT = "world_left", "world_right"


def outputs(**needed: Mapping[str, bool]) -> Demand:
    """A Demand to which each output has pushed its streams."""
    demand = Demand()
    for output, streams in needed.items():
        demand.push(output, streams)
    return demand


def push(demand: Demand, *idle: str) -> None:
    demand.push("ros", {it: it not in idle for it in (LEFT, RIGHT)})


def test_a_stream_rests_that_some_output_publishes_and_none_needs() -> None:
    nobody, everybody = {LEFT: False, RIGHT: False}, {LEFT: True, RIGHT: True}
    assert outputs().idle_streams(0.0) == set()
    assert outputs(ros=nobody).idle_streams(0.0) == {LEFT, RIGHT}
    assert outputs(ros=nobody, zenoh={LEFT: True}).idle_streams(0.0) == {RIGHT}
    assert outputs(ros={LEFT: False}, zenoh={RIGHT: False}).idle_streams(0.0) == {LEFT, RIGHT}
    assert outputs(ros=nobody, recording=everybody).idle_streams(0.0) == set()


def test_an_output_that_has_ended_needs_nothing() -> None:
    demand = outputs(ros={LEFT: False}, zenoh={LEFT: True})
    demand.push("zenoh", {})
    assert demand.idle_streams(0.0) == {LEFT}


def test_a_stream_that_a_subscriber_started_runs_on_for_some_seconds() -> None:
    demand = Demand()
    push(demand, LEFT, RIGHT)
    assert demand.idle_streams(0.0) == {LEFT, RIGHT}
    push(demand, RIGHT)
    assert demand.idle_streams(1.0) == {RIGHT}
    push(demand, LEFT, RIGHT)
    assert demand.idle_streams(100.0) == {RIGHT}
    assert demand.idle_streams(100.0 + STAYS_S - 0.01) == {RIGHT}
    assert demand.idle_streams(100.0 + STAYS_S) == {LEFT, RIGHT}


def test_a_subscriber_in_a_loop_starts_a_camera_once() -> None:
    demand = Demand()
    push(demand, LEFT)
    asked = [demand.idle_streams(0.0)]
    for step in range(1, 97):  # in 6 s
        push(demand, *([LEFT] if step % 2 == 0 else []))
        asked.append(demand.idle_streams(step / 16))
    assert sum(one != other for one, other in pairwise(asked)) == 1


def test_slower_ones_start_it_at_most_once_in_that_time() -> None:
    demand = Demand()
    push(demand, LEFT)
    changes_s, before = [], demand.idle_streams(0.0)
    for step in range(1, 6000):
        if step % 70 == 0:  # 7 s without, 0.1 s with
            push(demand)
        elif step % 70 == 1:
            push(demand, LEFT)
        if (now := demand.idle_streams(step / 10)) != before:
            changes_s.append(step / 10)
            before = now
    starts_s = changes_s[::2]
    assert len(starts_s) > 50
    assert min(b - a for a, b in pairwise(starts_s)) > STAYS_S


def test_a_stream_that_ran_before_anybody_needed_it_ends_at_once() -> None:
    demand = Demand()
    push(demand)
    assert demand.idle_streams(0.0) == set()
    push(demand, LEFT)
    assert demand.idle_streams(0.1) == {LEFT}


def test_a_stream_that_rests_again_stays_again_when_it_is_started_again() -> None:
    demand = Demand()
    push(demand, LEFT)
    for begin_s in (0.0, 50.0):
        assert demand.idle_streams(begin_s) == {LEFT}
        push(demand)
        demand.idle_streams(begin_s + 1)
        push(demand, LEFT)
        assert demand.idle_streams(begin_s + 2) == set()
        assert demand.idle_streams(begin_s + 2 + STAYS_S) == {LEFT}


def test_the_receiver_lets_a_camera_rest_without_another_event() -> None:
    request: Request = {LEFT: {"stream": 0, "format": "Grayscale"}, "tf": {"layout": "flat"}}
    server = Server(
        listen(("127.0.0.1", 0)),
        Everybody(),
        FakeSink(),
        request,
        ReceiverSettings("receiver", "test", limits=PATIENT),
        is_lazy=True,
    )
    server.demand("ros", {LEFT: False})
    server.start()
    try:
        with MockDevice(server.address, says_ping=True) as device:
            device.answer(device.reach_configure())
            asked = device.reconfigure()
            assert set(asked.streams) == {"tf"}
            device.expect_start(asked.request)
            server.demand("ros", {LEFT: True})
            asked = device.reconfigure()
            assert set(asked.streams) == {LEFT, "tf"}
            device.expect_start(asked.request)
            for is_needed in (False, True, False, True, False):
                server.demand("ros", {LEFT: is_needed})
            assert set(device.reconfigure().streams) == {"tf"}
    finally:
        server.stop()

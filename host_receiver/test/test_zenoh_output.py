"""The connection to the router, and what the streams are told of subscribers there."""

from collections.abc import Iterator
from queue import Empty, SimpleQueue

import pytest

from fake_sink import FakeSink
from ml2_receiver.session.report import Report
from ml2_receiver.session.streams import Request
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.wire.messages import Link
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.output import Identity, ZenohOutput
from waiting import LIMIT_S, await_true
from zenoh_peers import free_endpoint, open_router

BATTERY = load_table().streams["battery"].topics[0]


class FakeControl:
    """Keeps the calls of update()."""

    def __init__(self) -> None:
        self.updates: SimpleQueue[None] = SimpleQueue()

    def report(self) -> Report | None:
        return None

    def paired(self) -> None:
        return None

    def update(self) -> None:
        self.updates.put(None)

    def begin(self) -> None:
        raise AssertionError

    def pause(self) -> None:
        raise AssertionError

    def request(self, request: Request, link: Link | None = None) -> None:
        raise AssertionError

    def test_link(self) -> None:
        raise AssertionError


class Lab:
    """An output to an endpoint where no router is yet."""

    def __init__(self) -> None:
        self.endpoint, self.is_lazy = free_endpoint(), True
        self.other, self.control = FakeSink(), FakeControl()
        self.sinks = FanOut([self.other])
        self.output = ZenohOutput(
            session_configuration(self.endpoint, None),
            self.endpoint,
            Identity("", "/m", 0),
            load_table(),
            self.sinks,
            lambda: self.is_lazy,
        )


@pytest.fixture
def lab() -> Iterator[Lab]:
    lab = Lab()
    yield lab
    lab.output.close()


def test_streams_rest_once_there_is_a_router_but_no_subscriber(lab: Lab) -> None:
    lab.sinks.open(BATTERY)
    lab.output.serve(lab.control)
    lab.other.await_event("is not reached: Connection refused; trying again")
    assert lab.output.demand() == {}
    with open_router(lab.endpoint) as router:
        lab.control.updates.get(timeout=LIMIT_S)
        await_true(lambda: lab.output.demand() == {"battery": False})
        router.declare_subscriber("0/m/battery/**", lambda _: None)
        lab.control.updates.get(timeout=LIMIT_S)
        assert lab.output.demand() == {"battery": True}


def test_without_lazy_streams_are_not_asked_to_rest(lab: Lab) -> None:
    lab.is_lazy = False
    lab.sinks.open(BATTERY)
    with open_router(lab.endpoint) as router:
        router.declare_subscriber("0/m/battery/**", lambda _: None)
        lab.output.serve(lab.control)
        await_true(lambda: lab.output.demand() == {"battery": True})
        with pytest.raises(Empty):
            lab.control.updates.get(timeout=0.2)


def test_it_ends_without_having_begun(lab: Lab) -> None:
    lab.output.close()

"""The connection to the router, and what the streams are told of subscribers there."""

from collections.abc import Mapping
from queue import SimpleQueue

from fake_sink import FakeSink
from ml2_receiver.session.report import Report
from ml2_receiver.session.streams import Request
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.wire.messages import Link
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.output import Identity, ZenohOutput
from waiting import LIMIT_S
from zenoh_peers import free_endpoint, open_router

BATTERY = load_table().streams["battery"].topics[0]


class FakeControl:
    """Keeps what demand() is told."""

    def __init__(self) -> None:
        self.demands: SimpleQueue[Mapping[str, bool]] = SimpleQueue()

    def report(self) -> Report | None:
        return None

    def paired(self) -> None:
        return None

    def demand(self, output: str, streams: Mapping[str, bool]) -> None:
        assert output == "zenoh"
        self.demands.put(dict(streams))

    def begin(self) -> None:
        raise AssertionError

    def pause(self) -> None:
        raise AssertionError

    def request(self, request: Request, link: Link | None = None, *, is_lazy: bool = False) -> None:
        raise AssertionError

    def test_link(self) -> None:
        raise AssertionError

    def await_demand(self, expected: Mapping[str, bool]) -> None:
        """Waits until that is told; one change may be told twice."""
        while self.demands.get(timeout=LIMIT_S) != expected:
            pass


def test_streams_rest_once_there_is_a_router_but_no_subscriber() -> None:
    endpoint, control, other = free_endpoint(), FakeControl(), FakeSink()
    sinks = FanOut([other])
    sinks.open(BATTERY)
    configuration, identity = session_configuration(endpoint, None), Identity("", "/m", 0)
    with ZenohOutput(configuration, endpoint, identity, load_table(), sinks, control):
        other.await_event("is not reached: Connection refused; trying again")
        assert control.demands.empty()
        with open_router(endpoint) as router:
            control.await_demand({"battery": False})
            subscriber = router.declare_subscriber("0/m/battery/**", lambda _: None)
            control.await_demand({"battery": True})
            subscriber.undeclare()
            control.await_demand({"battery": False})
    control.await_demand({})

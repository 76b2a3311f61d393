"""A router that is killed, stands still, or whose link is cut: other sinks lose nothing by it."""

import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from queue import SimpleQueue

import pytest
import zenoh

from fake_sink import FakeSink
from ml2_receiver.session.sink import Publish
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.sink import ZenohSink
from proxy import Proxy
from repeated import repeated
from ros_processes import Child
from waiting import LIMIT_S, await_true
from zenoh_peers import free_endpoint, open_client, open_router

TABLE = load_table()
IMAGE = TABLE.streams["world_left"].topics[0]
IMU = TABLE.streams["gyro_left"].topics[0]
HERE = Path(__file__).parent
CUTS = 50
# A put with CongestionControl.BLOCK would wait for so long, until Zenoh gives up the connection.
BLOCKED_S = LIMIT_S / 2
SETTINGS = f"""{{
  connect: {{retry: {{period_init_ms: 20, period_max_ms: 20}}}},
  transport: {{link: {{tx: {{queue: {{congestion_control: {{
    block: {{wait_before_close: {BLOCKED_S * 1e6:.0f}}}}}}}}}}}}},
}}"""


SUBSCRIBE = """
import sys, zenoh_peers
with zenoh_peers.open_client(sys.argv[1]) as session:
    session.declare_subscriber("0/m/**", lambda sample: None)
    print("ready", flush=True)
    sys.stdin.read()
"""


class Peer(Child):
    """A program of Zenoh in a process, which can be stopped and killed."""

    def __init__(self, *arguments: str) -> None:
        super().__init__(*arguments)
        assert self.line() == "ready"

    def kill(self) -> None:
        self.process.kill()
        self.wait()


def router_on(endpoint: str) -> Peer:
    return Peer(str(HERE / "zenoh_peers.py"), endpoint, "{}")


def reader_on(endpoint: str) -> Peer:
    return Peer("-c", f"import sys; sys.path.append({str(HERE)!r})\n{SUBSCRIBE}", endpoint)


class Lane:
    """One topic that goes to Zenoh and to another sink, as a lane of a headset publishes it."""

    def __init__(self, publish: Publish, payload_bytes: int) -> None:
        self._publish, self._payload = publish, bytearray(payload_bytes)
        self.sent = 0
        self.longest_s = 0.0

    def send(self) -> None:
        self._payload[:8] = self.sent.to_bytes(8, "little")
        began_s = time.monotonic()
        self._publish(self._payload)
        self.longest_s = max(self.longest_s, time.monotonic() - began_s)
        self.sent += 1


class Outputs:
    """Zenoh and a sink that takes all, behind one FanOut."""

    def __init__(self, sink: ZenohSink, links: SimpleQueue[zenoh.SampleKind]) -> None:
        self.zenoh, self.other, self._links = sink, FakeSink(), links
        self._all = FanOut([self.other, sink])
        self.images = Lane(self._all.open(IMAGE), 1_000_000)
        self.imu = Lane(self._all.open(IMU), 324)

    def is_balanced(self) -> bool:
        """Each message went to both; Zenoh took it, whatever it did with it."""
        taken = self.zenoh.published()
        return all(
            len(self.other.payloads[topic.name]) == lane.sent == taken[f"/m/{topic.name}"]
            for topic, lane in ((IMAGE, self.images), (IMU, self.imu))
        )

    def await_link(self, kind: zenoh.SampleKind) -> None:
        """Waits until the link to the router is back (PUT), or gone (DELETE)."""
        assert self._links.get(timeout=LIMIT_S) == kind

    def longest_s(self) -> float:
        return max(self.images.longest_s, self.imu.longest_s)


class Subscriber:
    """Takes the inertial samples, and knows by their numbers what it lacks."""

    def __init__(self, endpoint: str, retry: object) -> None:
        self.numbers: list[int] = []
        self.session = open_client(endpoint, **{"connect/retry": retry})
        self.session.declare_subscriber("0/m/**", self._take)

    def _take(self, sample: zenoh.Sample) -> None:
        if IMU.name in str(sample.key_expr):
            assert sample.attachment is not None
            number = int.from_bytes(sample.attachment.to_bytes()[:8], "little")
            assert int.from_bytes(sample.payload.to_bytes()[:8], "little") == number - 1
            self.numbers.append(number)


@contextmanager
def outputs(endpoint: str, tmp_path: Path) -> Iterator[Outputs]:
    file = tmp_path / "settings.json5"
    file.write_text(SETTINGS)
    with zenoh.open(session_configuration(endpoint, file)) as session:
        links: SimpleQueue[zenoh.SampleKind] = SimpleQueue()
        session.info.declare_transport_events_listener(lambda event: links.put(event.kind))
        sink = ZenohSink(session, TABLE, "/m", "", 0, lambda: None)
        yield Outputs(sink, links)
        sink.close()


def test_a_router_that_was_killed_and_started_again_gets_what_follows(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    with ExitStack() as stack:
        router = stack.enter_context(router_on(endpoint))
        out = stack.enter_context(outputs(endpoint, tmp_path))
        retry = {"period_init_ms": 20, "period_max_ms": 20}
        subscriber = Subscriber(endpoint, retry)
        stack.callback(subscriber.session.close)
        with repeated(out.imu.send, 0.002), repeated(out.images.send, 0.03):
            await_true(lambda: len(subscriber.numbers) > 50)
            router.kill()
            await_true(lambda: not out.zenoh.demand()[IMU.stream])
            before, sent = len(subscriber.numbers), out.imu.sent
            await_true(lambda: out.imu.sent > sent + 50)
            stack.enter_context(router_on(endpoint))
            await_true(lambda: len(subscriber.numbers) > before + 50)
        numbers = subscriber.numbers
    assert numbers == sorted(set(numbers))
    gaps = numbers[-1] - numbers[0] + 1 - len(numbers)
    assert gaps > 50
    assert out.is_balanced()
    assert out.longest_s() < BLOCKED_S


@pytest.mark.parametrize("stalled", ["router", "subscriber"])
def test_one_that_stands_still_blocks_no_lane(tmp_path: Path, stalled: str) -> None:
    endpoint = free_endpoint()
    with ExitStack() as stack:
        router = stack.enter_context(router_on(endpoint))
        reader = stack.enter_context(reader_on(endpoint))
        out = stack.enter_context(outputs(endpoint, tmp_path))
        await_true(lambda: out.zenoh.demand()[IMAGE.stream])
        child = router if stalled == "router" else reader
        child.process.send_signal(signal.SIGSTOP)
        for _ in range(100):
            out.images.send()
            out.imu.send()
        assert out.is_balanced()
        router.kill()
        reader.kill()
    assert out.longest_s() < BLOCKED_S


def test_a_link_that_is_cut_again_and_again_blocks_no_lane(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    with open_router(endpoint) as router, Proxy(endpoint.removeprefix("tcp/")) as link:
        router.declare_subscriber("0/m/**", lambda _: None)
        with outputs(f"tcp/{link.address}", tmp_path) as out:
            with repeated(out.imu.send, 0.001), repeated(out.images.send, 0.01):
                await_true(lambda: out.zenoh.demand()[IMU.stream])
                for _ in range(CUTS):
                    link.cut()
                    out.await_link(zenoh.SampleKind.DELETE)
                    out.await_link(zenoh.SampleKind.PUT)
                await_true(lambda: out.zenoh.demand()[IMU.stream])
            assert out.is_balanced()
            assert out.longest_s() < BLOCKED_S

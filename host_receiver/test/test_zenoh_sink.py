"""The sink that publishes on Zenoh, with a router and subscribers in this process."""

import threading
import time
from collections.abc import Iterator
from queue import SimpleQueue
from typing import Any

import pytest
import zenoh

import bag_scene
from ml2_receiver.errors import PublishError
from ml2_receiver.session.sink import Applied
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.plain_messages import decode_string
from ml2_receiver.wire.messages import StreamAnswer
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.sink import ZenohSink
from repeated import repeated
from waiting import LIMIT_S, await_true

DOMAIN = 7
TABLE = load_table()
BATTERY = TABLE.streams["battery"].topics[0]
IMAGE = next(it for it in TABLE.streams["world_left"].topics if it.name.endswith("image_raw"))
(STATIC,) = (it for it in TABLE.streams["tf"].topics if it.role == "tf_static")


class Taker:
    """A subscriber that keeps samples."""

    def __init__(self, session: zenoh.Session, key: str) -> None:
        self._samples: SimpleQueue[zenoh.Sample] = SimpleQueue()
        self.subscriber = session.declare_subscriber(key, self._samples.put)

    def take(self) -> zenoh.Sample:
        return self._samples.get(timeout=LIMIT_S)


@pytest.fixture
def changes() -> "SimpleQueue[None]":
    return SimpleQueue()


@pytest.fixture
def sink(router: zenoh.Session, endpoint: str, changes: "SimpleQueue[None]") -> Iterator[ZenohSink]:
    with zenoh.open(session_configuration(endpoint, None)) as session:
        sink = ZenohSink(session, TABLE, "/r/magic_leap2", "r", DOMAIN, lambda: changes.put(None))
        yield sink
        sink.close()


def await_demand(sink: ZenohSink, changes: "SimpleQueue[None]", expected: dict[str, bool]) -> None:
    """Waits until the sink tells of this; one change may be told twice."""
    changes.get(timeout=LIMIT_S)
    while sink.demand() != expected:
        changes.get(timeout=LIMIT_S)


def tokens(router: zenoh.Session) -> set[str]:
    replies: Any = router.liveliness().get(f"@ros2_lv/{DOMAIN}/**", timeout=LIMIT_S)
    return {str(reply.ok.key_expr) for reply in replies if reply.ok is not None}


def test_payloads_travel_unchanged_and_numbered(
    router: zenoh.Session, sink: ZenohSink, changes: "SimpleQueue[None]"
) -> None:
    publish = sink.open(BATTERY)
    taker = Taker(router, f"{DOMAIN}/r/magic_leap2/battery/**")
    await_demand(sink, changes, {"battery": True})
    buffer = bytearray(bag_scene.battery(0))
    for number in range(5):
        buffer[:] = bag_scene.battery(number)
        publish(buffer)
    buffer[:] = bytes(len(buffer))
    gids = set()
    for number in range(5):
        sample = taker.take()
        assert sample.payload.to_bytes() == bag_scene.battery(number)
        assert sample.attachment is not None
        attached = sample.attachment.to_bytes()
        assert int.from_bytes(attached[:8], "little") == number + 1
        assert abs(int.from_bytes(attached[8:16], "little") - time.time_ns()) < LIMIT_S * 1e9
        gids.add(attached[17:])
    assert len(gids) == 1
    assert sink.published() == {"/r/magic_leap2/battery": 5}


@pytest.mark.parametrize(
    ("topic", "priority"),
    [(BATTERY, zenoh.Priority.REAL_TIME), (IMAGE, zenoh.Priority.DATA_LOW)],
)
def test_images_give_way_and_nothing_waits(
    router: zenoh.Session, sink: ZenohSink, topic: Any, priority: zenoh.Priority
) -> None:
    taker = Taker(router, f"{DOMAIN}/r/{topic.full_name('magic_leap2')}/**")
    publish = sink.open(topic)
    await_true(lambda: sink.demand()[topic.stream])
    publish(bytearray(bag_scene.image(0)))
    sample = taker.take()
    assert sample.priority == priority
    assert sample.congestion_control == zenoh.CongestionControl.DROP
    assert not sample.express


def test_a_late_subscriber_gets_what_is_latched(router: zenoh.Session, sink: ZenohSink) -> None:
    sink.open(STATIC)(bytearray(b"mounting"))
    sink.configured(Applied("headset", "session", {"tf": StreamAnswer("applied", {})}, [STATIC]))
    history = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
    found: SimpleQueue[bytes] = SimpleQueue()
    for name in ("tf_static", "r/magic_leap2/config"):
        zenoh.ext.declare_advanced_subscriber(
            router,
            f"{DOMAIN}/{name}/*/*",
            lambda sample: found.put(sample.payload.to_bytes()),
            history=history,
        )
    got = {found.get(timeout=LIMIT_S), found.get(timeout=LIMIT_S)}
    assert b"mounting" in got
    (config,) = got - {b"mounting"}
    assert b'"headset":"headset"' in decode_string(config).replace(b" ", b"")


def test_events_are_on_the_topic_log(router: zenoh.Session, sink: ZenohSink) -> None:
    taker = Taker(router, f"{DOMAIN}/r/magic_leap2/log/**")

    with repeated(lambda: sink.event("said"), 0.05):
        assert decode_string(taker.take().payload.to_bytes()) == b"said"


def test_a_topic_that_ended_has_no_token_and_publishes_nothing(
    router: zenoh.Session, sink: ZenohSink
) -> None:
    publish = sink.open(BATTERY)
    await_true(lambda: any("%r%magic_leap2%battery/" in it for it in tokens(router)))
    sink.configured(Applied("headset", "session", {}, []))
    await_true(lambda: not any("battery" in it for it in tokens(router)))
    taker = Taker(router, f"{DOMAIN}/r/magic_leap2/battery/**")
    publish(bytearray(b"too late"))
    again = sink.open(BATTERY)
    await_true(lambda: sink.demand()["battery"])
    again(bytearray(b"again"))
    assert taker.take().payload.to_bytes() == b"again"


def test_a_topic_ends_while_it_publishes(router: zenoh.Session, sink: ZenohSink) -> None:
    publish = sink.open(IMAGE)
    ended = threading.Event()
    failures: list[BaseException] = []

    def stream() -> None:
        try:
            while not ended.is_set():
                publish(bytearray(100_000))
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=stream)
    thread.start()
    await_true(lambda: sink.published()[IMAGE.full_name("/r/magic_leap2")] > 10)
    sink.configured(Applied("headset", "session", {}, []))
    ended.set()
    thread.join()
    assert failures == []


def test_demand_follows_topics_and_subscribers(
    router: zenoh.Session, sink: ZenohSink, changes: "SimpleQueue[None]"
) -> None:
    sink.open(BATTERY)
    await_demand(sink, changes, {"battery": False})
    sink.open(IMAGE)
    await_demand(sink, changes, {"battery": False, "world_left": False})
    taker = Taker(router, f"{DOMAIN}/r/magic_leap2/battery/**")
    await_demand(sink, changes, {"battery": True, "world_left": False})
    taker.subscriber.undeclare()
    await_demand(sink, changes, {"battery": False, "world_left": False})
    sink.configured(Applied("m", "s", {IMAGE.stream: StreamAnswer("applied", {})}, [IMAGE]))
    await_demand(sink, changes, {"world_left": False})


def test_a_session_that_ended_refuses_messages(router: zenoh.Session, endpoint: str) -> None:
    session = zenoh.open(session_configuration(endpoint, None))
    sink = ZenohSink(session, TABLE, "/magic_leap2", "", DOMAIN, lambda: None)
    publish = sink.open(STATIC)
    session.close()
    with pytest.raises(PublishError):
        publish(bytearray(b"payload"))
    assert sink.published() == {"/tf_static": 0}

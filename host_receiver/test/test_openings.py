"""Tests the openings of apps and their frames; tests/conformance has the malformed ones."""

import random
import socket
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import pytest

from fake_sink import FakeGraph
from ml2_receiver.configuration.app_rules import AppRules, NameRules
from ml2_receiver.errors import ErrorCode, ProtocolError
from ml2_receiver.session.books import Book, Books
from ml2_receiver.session.connection import Connection
from ml2_receiver.session.connection_io import ConnectionIO
from ml2_receiver.session.downlink import Downlink
from ml2_receiver.session.openings import LANE_KINDS, Openings
from ml2_receiver.session.subscription_queue import Pieces, SubscriptionQueue
from ml2_receiver.transport.transport import PlainTransport
from ml2_receiver.wire.frame import MAGIC, VERSION, Frame, FrameParser, Header
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.kinds import BULK_LANES, ROS, ROS_LANES, Kind, Side
from ml2_receiver.wire.messages import ClockStatus, Status
from ml2_receiver.wire.opening_bodies import CallStatus, Close, Closed, Failure, Open, Opened
from waiting import LIMIT_S, await_true

ANY = NameRules(("/**",))
SMALL, LARGE, CLIENT, SERVICE = 1, 2, 3, 4
PAYLOAD = b"\0\1\0\0\0"
LAST = (1 << 32) - 1


def of(rules: AppRules, graph: FakeGraph) -> Openings:
    return Openings(lambda: rules, graph, Downlink(Books()))


def frame(
    kind: Kind, id: int = 0, number: int = 0, body: bytes = b"", capture_ns: int = 0
) -> Frame:
    header = Header(MAGIC, VERSION, kind, 0, id, number, len(body), capture_ns, 0)
    return Frame(header, bytearray(body))


def answers(openings: Openings, kind: Kind, body: JsonBody) -> list[Opened | Closed]:
    found = openings.answers(frame(kind, body=body.to_bytes()))
    assert found is not None
    return [it for _, it in found]


def opened(openings: Openings, wanted: Open) -> Opened:
    (answer,) = answers(openings, Kind.OPEN, wanted)
    assert isinstance(answer, Opened)
    return answer


def wanted(
    id: int, kind: str = "subscription", name: str = "/scan", *, bulk: bool | None = None
) -> Open:
    return Open(id, kind, name, "std_msgs/msg/String", bulk=bulk)


@pytest.fixture
def graph() -> FakeGraph:
    return FakeGraph()


@pytest.fixture
def openings(graph: FakeGraph) -> Openings:
    made = of(AppRules(ANY, ANY, ANY, ANY), graph).joined("ros").joined("bulk_1")
    opened(made, wanted(SMALL))
    opened(made, wanted(LARGE, bulk=True))
    opened(made, wanted(CLIENT, "client"))
    opened(made, wanted(SERVICE, "service"))
    return made


@pytest.mark.parametrize(
    ("kind", "allowing"),
    [
        ("subscription", AppRules(subscribe=ANY)),
        ("client", AppRules(call=ANY)),
        ("service", AppRules(offer=ANY)),
    ],
)
def test_a_name_is_opened_by_a_rule_for_its_use_alone(
    kind: str, allowing: AppRules, graph: FakeGraph
) -> None:
    assert opened(of(allowing, graph).joined("ros"), wanted(1, kind)).result == "opened"
    others = {use: ANY for use in vars(allowing) if not getattr(allowing, use).rules}
    refused = opened(of(AppRules(**others), graph).joined("ros"), wanted(1, kind))
    assert refused.result == "refused"
    assert "/scan" in str(refused.reason)


def test_a_transform_needs_a_rule_that_has_tf(graph: FakeGraph) -> None:
    tree = Open(1, "transform", frame="base_link", reference="map")
    for rule, result in (("/tf", "opened"), ("/scan", "refused")):
        rules = AppRules(subscribe=NameRules((rule,)))
        assert opened(of(rules, graph).joined("ros"), tree).result == result


def test_without_rules_nothing_is_opened(graph: FakeGraph) -> None:
    openings = of(AppRules(), graph).joined("ros")
    for id, kind in enumerate(("subscription", "client", "service"), 1):
        assert opened(openings, wanted(id, kind)).result == "refused"
    assert not any(vars(openings.allowed).values())


def test_openings_that_new_rules_do_not_have_end_and_the_others_go_on(graph: FakeGraph) -> None:
    rules = AppRules(subscribe=ANY, call=ANY)
    openings = Openings(lambda: rules, graph, Downlink(Books())).joined("ros")
    opened(openings, wanted(SMALL, name="/robot/scan"))
    opened(openings, wanted(LARGE, name="/scan"))
    opened(openings, wanted(CLIENT, "client"))
    opened(openings, Open(9, "transform", frame="base_link", reference="map"))
    assert openings.ended() == []
    rules = AppRules(subscribe=NameRules(("/robot/*",)), call=ANY)
    reasons = {LARGE: "/scan", 9: "/tf"}
    assert openings.ended() == [
        Closed(id, f"no rule in app.subscribe has {name}", "rules") for id, name in reasons.items()
    ]
    assert graph.closed == [LARGE, 9]
    assert openings.ended() == []
    assert openings.late == 0
    assert opened(openings, wanted(10)).code == "rules"
    rules = AppRules(subscribe=ANY)
    assert opened(openings, wanted(11)).result == "opened"
    assert [it.id for it in openings.ended()] == [CLIENT]


def test_taken_is_for_what_was_sent_since_the_last_one(
    openings: Openings, graph: FakeGraph
) -> None:
    for number, sent in ((LAST - 1, LAST - 1), (LAST, LAST), (2, 3)):
        openings.sent(LARGE, sent)
        openings.received("bulk_1", frame(Kind.TAKEN, LARGE, number))
    assert graph.received_numbers == [(LARGE, LAST - 1), (LARGE, LAST), (LARGE, 2)]
    for number in (2, 4, LAST):
        with pytest.raises(ProtocolError, match="TAKEN") as refusal:
            openings.received("bulk_1", frame(Kind.TAKEN, LARGE, number))
        assert refusal.value.code == ErrorCode.UNEXPECTED


def test_a_request_is_answered_once(openings: Openings, graph: FakeGraph) -> None:
    for number in (LAST, 1):
        openings.begins(Kind.REQUEST, SERVICE, number)
    failure = Failure("refused", "no").to_bytes()
    for _ in range(2):
        openings.received("ros", frame(Kind.RESPONSE, SERVICE, LAST, PAYLOAD))
        openings.received("ros", frame(Kind.FAILURE, SERVICE, 1, failure))
    openings.received("ros", frame(Kind.RESPONSE, SERVICE, 0, PAYLOAD))  # a gap in the numbers
    assert graph.received_numbers == [(SERVICE, LAST), (SERVICE, 1)]
    assert openings.late == 3
    with pytest.raises(ProtocolError, match="never asked"):
        openings.received("ros", frame(Kind.RESPONSE, SERVICE, 2, PAYLOAD))


def test_64_requests_of_all_clients_are_under_way_at_most(
    openings: Openings, graph: FakeGraph
) -> None:
    clients = [CLIENT, 11, 12, 13, 14]
    for id in clients[1:]:
        opened(openings, wanted(id, "client"))
    ask = [frame(Kind.REQUEST, id, number, PAYLOAD, 1) for id in clients for number in range(16)]
    answered = [openings.received("ros", it) for it in ask]
    assert [it and it.code for it in answered] == [None] * 64 + ["busy"] * 16
    openings.begins(Kind.RESPONSE, CLIENT, 0)
    assert openings.received("ros", frame(Kind.REQUEST, 14, 99, PAYLOAD, 1)) is None
    assert len(graph.received_numbers) == 65


def test_each_request_is_counted_with_its_answer(openings: Openings) -> None:
    for number in range(17):
        openings.received("ros", frame(Kind.REQUEST, CLIENT, number, PAYLOAD, 1))
        openings.begins(Kind.REQUEST, SERVICE, number)
    openings.begins(Kind.RESPONSE, CLIENT, 0)
    openings.begins(Kind.FAILURE, CLIENT, 1)
    for kind, number in ((Kind.RESPONSE, 3), (Kind.RESPONSE, 3), (Kind.RESPONSE, 5)):
        openings.received("ros", frame(kind, SERVICE, number, PAYLOAD))
    expected = [
        ("client", {Kind.REQUEST: 17, Kind.RESPONSE: 1, Kind.FAILURE: 2}),
        ("service", {Kind.REQUEST: 17, Kind.RESPONSE: 2}),
    ]
    of_app = CallStatus(18, 1, {"busy": 2, "link_down": 15})
    clock = ClockStatus("synchronised", -5, 6, 7)
    status = Status(False, 1, {}, clock, calls={f"{CLIENT}": of_app})
    for _ in range(2):
        calls = openings.report(status).calls
        assert [(it.kind, dict(it.counts)) for it in calls] == expected
        assert [it.device for it in calls] == [of_app, None]
        openings.finish()


def test_what_is_closed_is_closed_in_the_graph_and_is_late_from_then_on(
    openings: Openings, graph: FakeGraph
) -> None:
    assert answers(openings, Kind.CLOSE, Close(CLIENT)) == [Closed(CLIENT, "the app closed it")]
    openings.received("ros", frame(Kind.REQUEST, CLIENT, 0, PAYLOAD, 1))
    assert answers(openings, Kind.CLOSE, Close(CLIENT)) == []
    assert openings.end(SMALL, "the rules have changed") == Closed(SMALL, "the rules have changed")
    assert openings.late == 2
    openings.finish()
    assert sorted(graph.closed) == [SMALL, LARGE, CLIENT, SERVICE]


@pytest.mark.parametrize("seed", range(3))
def test_each_frame_is_passed_on_counted_answered_or_refused(
    seed: int, openings: Openings, graph: FakeGraph
) -> None:
    chance, outcomes = random.Random(seed), Counter[str]()
    answers(openings, Kind.CLOSE, Close(SMALL))
    for number in range(5000):
        drawn = any_frame(chance, number)
        if number % 7 == 0:
            openings.begins(Kind.REQUEST, SERVICE, number)
            openings.sent(LARGE, number)
        before = openings.late, len(graph.received_numbers)
        try:
            failure = openings.received(chance.choice(("ros", "bulk_1")), drawn)
            found = [failure.code] if failure else []
        except ProtocolError as error:
            found = [str(error.code)]
        found += ["late"] * (openings.late - before[0])
        found += ["passed on"] * (len(graph.received_numbers) - before[1])
        assert len(found) == 1, (drawn, found)
        outcomes[found[0]] += 1
    assert outcomes.keys() == {"passed on", "late", "busy", "unexpected", "malformed"}


def any_frame(chance: random.Random, number: int) -> Frame:
    kind = chance.choice(tuple(LANE_KINDS))
    body = Failure("c", "m").to_bytes() if kind is Kind.FAILURE else PAYLOAD
    if chance.random() < 0.1:
        body = b"?"
    near = max(0, number - chance.randrange(9))
    return frame(kind, chance.randrange(6), near, body, chance.randrange(5))


# Messages on their way to the app

# A message of so many bytes is written without others.
ALONE = 20_000


class Lane:
    """A lane on which frames are written in the test's own thread, until it is broken.

    Attributes:
        numbers: opening and number of each.
        together: how many each call had.
    """

    def __init__(self, downlink: Downlink, name: str = "ros") -> None:
        self._downlink = downlink
        (self._lane,) = (it for it in ROS_LANES if it.name == name)
        self.numbers: list[tuple[int, int]] = []
        self.together: list[int] = []
        self.is_broken = False

    def send_all(self, pieces: Pieces) -> None:
        if self.is_broken:
            raise ConnectionResetError
        data = memoryview(b"".join(pieces))
        frames = list(FrameParser(Side.RECEIVER, self._lane, has_openings=True).feed(data))
        self.numbers += [(it.header.channel, it.header.sequence) for it in frames]
        self.together.append(len(frames))

    def write(self, count: int) -> list[tuple[int, int]]:
        """Writes so many messages; returns their openings and numbers."""
        first = len(self.numbers)

        def send_all(pieces: Pieces) -> None:
            self.send_all(pieces)
            if len(self.numbers) >= first + count:
                self._downlink.stop()

        self._downlink.is_over = False
        self._downlink.write(self._lane, send_all)
        return self.numbers[first:]


def queue_of(
    downlink: Downlink, id: int = 1, name: str = "/scan", **more: Any
) -> SubscriptionQueue:
    wanted = Open(id, "subscription", name, "T", **more)
    return downlink.queue(wanted, name, is_bulk=bool(wanted.bulk))


def put(queue: SubscriptionQueue, count: int, length: int = 8) -> None:
    for _ in range(count):
        queue.put(PAYLOAD + bytes(length), 5)


@pytest.fixture
def downlink() -> Downlink:
    return Downlink(Books())


def balance(book: Book) -> dict[str, int]:
    """Returns how many messages went which way; fails if their sum is not all of them."""
    counts = {"sent": book.sent, "waiting": book.waiting, **book.dropped}
    assert sum(counts.values()) == book.produced
    return {what: count for what, count in counts.items() if count}


def test_the_newest_message_takes_the_place_of_an_older_one(downlink: Downlink) -> None:
    latest, every = queue_of(downlink), queue_of(downlink, 2, "/all", keep="all", depth=3)
    put(latest, 5)
    put(every, 5)
    assert Lane(downlink).write(4) == [(1, 4), (2, 2), (2, 3), (2, 4)]
    assert balance(latest.book) == {"sent": 1, "superseded": 4}
    assert balance(every.book) == {"sent": 3, "queue_full": 2}


def test_openings_take_turns_whatever_comes_meanwhile(downlink: Downlink) -> None:
    busy, latest = queue_of(downlink, keep="all", depth=100), queue_of(downlink, 2, "/latest")
    put(busy, 100, ALONE)
    put(latest, 1)
    lane = Lane(downlink)
    assert lane.write(1) == [(1, 0)]
    put(latest, 50)
    assert lane.write(2) == [(2, 50), (1, 1)]


def test_small_messages_that_wait_are_written_together_in_turn(downlink: Downlink) -> None:
    first, second = (queue_of(downlink, id, f"/{id}", keep="all") for id in (1, 2))
    put(first, 3, 5000)
    put(second, 1, 5000)
    put(first, 1, 50_000)
    lane = Lane(downlink)
    assert lane.write(5) == [(1, 0), (2, 0), (1, 1), (1, 2), (1, 3)]
    assert lane.together == [3, 1, 1]
    assert balance(first.book) == {"sent": 4}


def test_a_message_above_64_kib_is_too_large_and_leaves_a_gap(downlink: Downlink) -> None:
    queue = queue_of(downlink, keep="all")
    most = ROS.max_payload_bytes - len(PAYLOAD)
    for length in (most, most + 1, most):
        put(queue, 1, length)
    assert Lane(downlink).write(2) == [(1, 0), (1, 2)]
    assert balance(queue.book) == {"sent": 2, "too_large": 1}


def test_queues_together_hold_16_mib(downlink: Downlink) -> None:
    queues = [queue_of(downlink, id, f"/{id}", keep="all", depth=100) for id in range(1, 65)]
    for queue in queues:
        put(queue, 100, ROS.max_payload_bytes - len(PAYLOAD))
    waiting = sum(it.book.waiting for it in queues)
    assert waiting * ROS.max_payload_bytes == 16 << 20
    assert sum(it.book.dropped["queue_full"] for it in queues) == 6400 - waiting


def test_two_large_messages_of_an_opening_are_sent_before_the_app_takes_one(
    downlink: Downlink,
) -> None:
    first, _, _, _, fifth = (
        queue_of(downlink, id, f"/{id}", keep="all", bulk=True) for id in range(1, 6)
    )
    assert first.lane == fifth.lane == BULK_LANES[0]
    lane = Lane(downlink, "bulk_1")
    put(first, 4, 70_000)
    assert lane.write(2) == [(1, 0), (1, 1)]
    put(fifth, 1, 70_000)
    assert lane.write(1) == [(5, 0)]
    downlink.taken(1, 1)
    assert lane.write(2) == [(1, 2), (1, 3)]
    assert balance(first.book) == {"sent": 4}


def test_an_app_that_takes_nothing_holds_128_mib(downlink: Downlink) -> None:
    most = BULK_LANES[0].max_payload_bytes - len(PAYLOAD)
    lanes = [Lane(downlink, it.name) for it in BULK_LANES]
    for id in range(1, 6):
        queue = queue_of(downlink, id, f"/{id}", keep="all", bulk=True)
        for _ in range(2 * (id < 5)):
            put(queue, 1, most)
            lanes[(id - 1) % 4].write(1)
    put(queue, 1)
    writing = threading.Thread(target=lanes[0].write, args=[1])
    writing.start()
    downlink.taken(2, 1)
    writing.join()
    assert lanes[0].numbers == [(1, 0), (1, 1), (5, 0)]


def test_the_kernel_tells_what_is_under_way() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        peer = socket.create_connection(server.getsockname(), LIMIT_S)
        transport = PlainTransport(server.accept()[0])
    while transport.send(bytes(1 << 16)):
        pass
    assert transport.unacknowledged() > 0
    assert 0 < transport.least_round_trip_s() < LIMIT_S
    with ThreadPoolExecutor(1) as beside, peer:
        beside.submit(lambda: all(iter(lambda: peer.recv(1 << 20), b"")))
        await_true(lambda: transport.unacknowledged() == 0)
        transport.end()
    transport.close()
    assert (transport.unacknowledged(), transport.least_round_trip_s()) == (0, 0)


def test_requests_of_the_time_tell_the_pacing_how_long_they_took(
    openings: Openings, monkeypatch: pytest.MonkeyPatch
) -> None:
    ways_s: list[float] = []
    monkeypatch.setattr(openings.downlink.pacing, "requested", ways_s.append)
    connected, peer = socket.socketpair()
    with connected, peer:
        io = ConnectionIO(PlainTransport(connected), Connection("", 0, 0, openings=openings))
        asked = frame(Kind.TIME_REQUEST, body=(1_000_000).to_bytes(8, "little"))
        io.answer_time(asked, received_ns=3_500_000)
    assert ways_s == pytest.approx([0.0025])


class Watched(PlainTransport):
    """Tells when what is sent waits for room."""

    def __init__(self, connected: socket.socket) -> None:
        super().__init__(connected)
        self.waits = threading.Event()

    def send_all(self, data: bytes | memoryview) -> None:
        self.waits.set()
        super().send_all(data)


def test_the_failure_of_a_request_too_many_waits_until_the_app_reads(openings: Openings) -> None:
    connected, peer = socket.socketpair()
    with connected, peer, ThreadPoolExecutor(1) as pool:
        peer.settimeout(LIMIT_S)
        transport = Watched(connected)
        io = ConnectionIO(transport, Connection("", 0, 0, lane=ROS, openings=openings))
        for number in range(16):
            io.pass_on(frame(Kind.REQUEST, CLIENT, number, PAYLOAD, 1), openings)
        unread = 0
        with suppress(BlockingIOError):
            while True:
                unread += connected.send(bytes(1 << 16), socket.MSG_DONTWAIT)
        passed = pool.submit(io.pass_on, frame(Kind.REQUEST, CLIENT, 16, PAYLOAD, 1), openings)
        await_true(lambda: transport.waits.is_set() or passed.done())
        assert not passed.done()
        while unread:
            unread -= len(peer.recv(unread))
        parser = FrameParser(Side.RECEIVER, ROS, has_openings=True)
        (found,) = parser.feed(memoryview(peer.recv(1 << 16)))
        passed.result(LIMIT_S)
        assert Failure.parse(found.body).code == "busy"
        assert not io.is_aborted


def test_messages_beyond_max_hz_have_no_number(
    downlink: Downlink, monkeypatch: pytest.MonkeyPatch
) -> None:
    queue = queue_of(downlink, keep="all", depth=100, max_hz=10)
    for millisecond in range(1000):
        monkeypatch.setattr(time, "monotonic", lambda at=millisecond: 100 + at / 1000)
        put(queue, 1)
    assert queue.book.produced == 10


def test_what_waits_when_a_session_ends_is_lost_with_the_link(downlink: Downlink) -> None:
    queue = queue_of(downlink, keep="all")
    put(queue, 3, ALONE)
    Lane(downlink).write(1)
    downlink.close(1, "link_down")
    put(queue, 1)
    assert balance(queue.book) == {"sent": 1, "link_down": 2}
    assert [it.book for it in downlink.reports({})] == [queue.book.copy()]


def test_a_message_that_cannot_be_written_is_lost_with_the_link(downlink: Downlink) -> None:
    queue, lane = queue_of(downlink, keep="all"), Lane(downlink)
    put(queue, 1, ALONE)
    put(queue, 2)
    lane.is_broken = True
    assert lane.write(1) == []
    assert balance(queue.book) == {"waiting": 2, "link_down": 1}
    assert lane.write(1) == []
    assert balance(queue.book) == {"link_down": 3}


def test_numbers_go_on_in_the_next_session_and_what_never_arrived_is_lost() -> None:
    books = Books()
    first, second, third = (Downlink(books) for _ in range(3))
    put(queue_of(first, keep="all"), 9)
    Lane(first).write(9)
    first.close(1, "link_down")
    queue = queue_of(second, keep="all", received=7)
    assert balance(queue.book) == {"sent": 7, "link_down": 2}
    put(queue, 1)
    assert Lane(second).write(1) == [(1, 9)]
    second.close(1, "link_down")
    again = queue_of(third, keep="all", received=10)
    assert balance(again.book) == {"sent": 8, "link_down": 2}


def test_numbers_begin_where_a_headset_is_that_met_another_receiver() -> None:
    books = Books()
    first, second = Downlink(books), Downlink(books)
    put(queue_of(first, received=LAST), 3)
    assert Lane(first).write(1) == [(1, 1)]
    first.close(1, "link_down")
    put(queue_of(second, received=1000), 1)
    assert Lane(second).write(1) == [(1, 1000)]


def test_books_of_names_that_nobody_has_open_are_forgotten_in_the_end() -> None:
    books = Books()
    downlink = Downlink(books)
    kept = queue_of(downlink, 1, "/kept")
    put(kept, 1)
    for id in range(2, 3000):
        queue_of(downlink, id, f"/{id}")
        downlink.close(id, "closed")
    assert len(books) <= 257
    assert queue_of(downlink, 3000, "/kept").book is kept.book


@pytest.mark.parametrize("seed", range(5))
def test_the_book_of_whatever_happens_is_balanced(seed: int) -> None:
    chance, books = random.Random(seed), Books()
    expected = [0, 0, 0]
    for _ in range(40):
        downlink = Downlink(books)
        lane = Lane(downlink)
        queues = [
            queue_of(
                downlink,
                id + 1,
                f"/{id}",
                keep=chance.choice(["latest", "all"]),
                received=expected[id],
            )
            for id in range(3)
        ]
        arrived: list[tuple[int, int]] = []
        for _ in range(chance.randrange(20)):
            put(chance.choice(queues), chance.randrange(15), chance.choice([8, 70_000]))
            waiting = sum(it.book.waiting for it in queues)
            if waiting and chance.random() < 0.5:
                arrived += lane.write(chance.randrange(waiting) + 1)
        for id, number in arrived[: chance.randrange(len(arrived) + 1)]:
            assert number >= expected[id - 1]
            expected[id - 1] = number + 1
        for queue in queues:
            downlink.close(queue.id, "link_down")
            balance(queue.book)
            assert queue.book.waiting == 0

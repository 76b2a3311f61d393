"""What an app may open, and what comes of its frames; tests/conformance has the malformed ones."""

import random
from collections import Counter

import pytest

from fake_sink import FakeGraph
from ml2_receiver.configuration.app_rules import AppRules, NameRules
from ml2_receiver.errors import ErrorCode, ProtocolError
from ml2_receiver.session.downlink import Books, Downlink
from ml2_receiver.session.openings import LANE_KINDS, Openings
from ml2_receiver.wire.frame import MAGIC, VERSION, Frame, Header
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.opening_bodies import Close, Closed, Failure, Open, Opened

ANY = NameRules(("/**",))
SMALL, LARGE, CLIENT, SERVICE = 1, 2, 3, 4
PAYLOAD = b"\0\1\0\0\0"
LAST = (1 << 32) - 1


def of(rules: AppRules, graph: FakeGraph) -> Openings:
    return Openings(rules, graph, Downlink(Books()))


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
        openings.asked(SERVICE, number)
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
    openings.answered(CLIENT, 0)
    assert openings.received("ros", frame(Kind.REQUEST, 14, 99, PAYLOAD, 1)) is None
    assert len(graph.received_numbers) == 65


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
            openings.asked(SERVICE, number)
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

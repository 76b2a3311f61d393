from dataclasses import replace

import pytest

from ml2_receiver.diagnostics import Diagnostics, Level, Row
from ml2_receiver.messages import ChannelStatus, ClockStatus
from ml2_receiver.report import Report, State, TopicReport
from ml2_receiver.statistics import TopicStatistics
from ml2_receiver.table import load_table

TOPIC = load_table().streams["world_left"].topics[0]
SENT_ALL = ChannelStatus(10, 10, {})


@pytest.fixture
def statistics() -> TopicStatistics:
    return TopicStatistics()


@pytest.fixture
def diagnostics() -> Diagnostics:
    return Diagnostics("/prefix")


def report(
    statistics: TopicStatistics,
    device: ChannelStatus | None = None,
    state: State = State.CONNECTED,
) -> Report:
    clock = ClockStatus("synchronised", -5, 6, 7)
    return Report(state, "Zoë", "id", clock, 3, True, [TopicReport(TOPIC, statistics, device)])


def receive(statistics: TopicStatistics, *sequences: int) -> None:
    for sequence in sequences:
        statistics.record(sequence, 125_000, 4_000_000)


def topic_row(diagnostics: Diagnostics, report: Report, now_s: float) -> Row:
    _, row = diagnostics.rows(report, now_s)
    return row


def test_without_a_headset_there_is_a_row_that_says_so(diagnostics: Diagnostics) -> None:
    (row,) = diagnostics.rows(None, 0.0)
    assert (row.name, row.level, row.values) == ("session", Level.OK, {"state": "waiting"})


def test_the_session_has_a_row(diagnostics: Diagnostics, statistics: TopicStatistics) -> None:
    row, _ = diagnostics.rows(report(statistics), 0.0)
    assert (row.name, row.level) == ("session", Level.OK)
    assert row.values == {
        "state": "connected",
        "headset": "Zoë",
        "device_id": "id",
        "skipped_frames": "3",
        "final": "true",
        "clock.state": "synchronised",
        "clock.offset_ns": "-5",
        "clock.uncertainty_ns": "6",
        "clock.round_trip_ns": "7",
    }


def test_a_lost_session_is_an_error(diagnostics: Diagnostics, statistics: TopicStatistics) -> None:
    rows = diagnostics.rows(report(statistics, state=State.LOST), 0.0)
    assert [row.level for row in rows] == [Level.ERROR, Level.ERROR]
    rows = diagnostics.rows(report(statistics, state=State.ENDED), 0.0)
    assert [row.level for row in rows] == [Level.OK, Level.OK]


def test_rates_are_of_the_time_since_the_last_call(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, 0)
    assert topic_row(diagnostics, report(statistics), 10.0).values["rate_hz"] == "0.00"
    receive(statistics, 1, 2, 3)
    values = topic_row(diagnostics, report(statistics), 12.0).values
    assert (values["rate_hz"], values["mbit_per_s"]) == ("1.50", "1.50")


def test_a_topic_has_its_numbers(diagnostics: Diagnostics, statistics: TopicStatistics) -> None:
    receive(statistics, 0, 2)
    device = ChannelStatus(4, 3, {"queue_full": 1, "link_down": 0})
    row = topic_row(diagnostics, report(statistics, device), 1.0)
    assert row.name == "/prefix/world_left/image_raw"
    assert row.values == {
        "stream": "world_left",
        "type": "sensor_msgs/msg/Image",
        "rate_hz": "0.00",
        "mbit_per_s": "0.00",
        "received": "2",
        "gaps": "1",
        "unpublished": "0",
        "produced": "4",
        "sent": "3",
        "dropped.queue_full": "1",
        "dropped.link_down": "0",
        "latency_p50_ms": "4.000",
        "latency_p99_ms": "4.000",
    }
    assert (row.level, row.message) == (Level.WARN, "lost messages: 1")


def test_at_the_end_messages_lost_after_the_last_arrival_are_gaps(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, 0, 2)
    device = ChannelStatus(5, 2, {"queue_full": 1, "link_down": 2})
    under_way = topic_row(diagnostics, report(statistics, device), 1.0)
    over = topic_row(diagnostics, report(statistics, device, State.ENDED), 1.0)
    assert (under_way.values["gaps"], over.values["gaps"]) == ("1", "3")


@pytest.mark.parametrize(("sent", "dropped"), [(4, 1), (3, 2), (2, 3), (1, 4)])
def test_at_the_end_what_was_sent_in_vain_is_dropped_by_the_link(
    diagnostics: Diagnostics, statistics: TopicStatistics, sent: int, dropped: int
) -> None:
    receive(statistics, 0, 2)
    device = ChannelStatus(sent + dropped, sent, {"link_down": dropped})
    values = topic_row(diagnostics, report(statistics, device, State.ENDED), 1.0).values
    assert values["dropped.link_down"] == values["gaps"] == "3"


@pytest.mark.parametrize(
    ("sequences", "dropped", "unpublished"),
    [((0, 2), {}, 0), ((0, 1), {"no_buffer": 1}, 0), ((0, 1), {}, 1)],
)
def test_any_loss_is_a_warning(
    diagnostics: Diagnostics, sequences: tuple[int, ...], dropped: dict[str, int], unpublished: int
) -> None:
    statistics = TopicStatistics()
    receive(statistics, *sequences)
    statistics.unpublished = unpublished
    device = ChannelStatus(2, 2, dropped)
    assert topic_row(diagnostics, report(statistics, device), 1.0).level == Level.WARN
    assert topic_row(diagnostics, report(statistics, SENT_ALL), 1.0).message != ""


def test_a_topic_is_stale_when_the_device_produces_and_nothing_arrives(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    levels = []
    for second in range(6):
        device = replace(SENT_ALL, produced=10 + second)
        if second < 2:
            receive(statistics, second)
        levels.append(topic_row(diagnostics, report(statistics, device), float(second)).level)
    assert levels == [Level.OK] * 4 + [Level.ERROR] * 2


def test_a_sensor_that_has_nothing_to_say_is_not_stale(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, *range(10))
    for second in range(6):
        row = topic_row(diagnostics, report(statistics, SENT_ALL), float(second))
        assert row.level == Level.OK

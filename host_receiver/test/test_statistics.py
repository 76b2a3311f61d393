import statistics as oracle
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ml2_receiver.session.connection import Route
from ml2_receiver.session.statistics import Instance, Latency, TopicStatistics
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, MAGIC, VERSION, Frame, Header
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import ChannelStatus

WRAP = 1 << 32
MS = 1_000_000
BATTERY = "battery"


def header(sequence: int, capture_ns: int = 0, send_ns: int = 0) -> Header:
    return Header(MAGIC, VERSION, Kind.DATA, 0, 1, sequence % WRAP, 10, capture_ns, send_ns)


def recorded(*sequences: int) -> TopicStatistics:
    statistics = TopicStatistics()
    for sequence in sequences:
        assert statistics.record(header(sequence), 0, 0)
    return statistics


@given(st.sets(st.integers(0, 2000), min_size=1), st.sampled_from([0, WRAP - 1000, 5]))
def test_produced_is_what_arrived_and_what_did_not(kept: set[int], first: int) -> None:
    statistics = TopicStatistics()
    for number in range(max(kept) + 1):
        if number in kept or number == 0:
            assert statistics.record(header(first + number), 0, 0)
    assert statistics.received == len(kept | {0})
    assert statistics.produced == first + max(kept) + 1
    assert statistics.gaps == statistics.produced - statistics.received


def test_what_went_to_another_receiver_before_is_no_loss() -> None:
    before = ChannelStatus(produced=5016, sent=5003, dropped={"queue_full": 7, "link_down": 3})
    instance = Instance("device", "instance", {BATTERY: before, "unheard/of": before})
    statistics = instance.statistics(BATTERY)
    for number in (5013, 5014, 5017):  # 5013 was queued
        assert statistics.record(header(number), 0, 0)
    assert not statistics.record(header(5017), 0, 0)
    assert (statistics.received, statistics.produced, statistics.gaps) == (3, 5, 2)
    assert statistics.last_number == 5017
    later = ChannelStatus(produced=5018, sent=5006, dropped={"queue_full": 9, "link_down": 3})
    assert statistics.of_this_receiver(later) == ChannelStatus(5, 3, {"queue_full": 2})
    # The device moves what it sent and nobody received to `link_down`
    assert instance.received() == {BATTERY: 5006, "unheard/of": 5003}


@given(
    st.integers(0, 3), st.integers(0, WRAP), st.sets(st.integers(0, 200), min_size=1), st.booleans()
)
def test_books_of_this_receiver_balance_from_wherever_they_begin(
    queued: int, sent: int, kept: set[int], wraps: bool
) -> None:
    sent += (WRAP - 100) * wraps
    before = ChannelStatus(sent + 4 + queued, sent, {"link_down": 4})
    statistics = TopicStatistics(before)
    for number in sorted(kept):
        assert statistics.record(header(sent + 4 + number), 0, 0)
    lost = max(kept) + 1 - len(kept)
    end = ChannelStatus(sent + 5 + max(kept), sent + len(kept), {"link_down": 4 + lost})
    device = statistics.of_this_receiver(end)
    assert device.produced == statistics.received + sum(device.dropped.values())
    assert statistics.gaps == lost


def test_a_device_whose_counts_shrink_never_counts_below_nothing() -> None:
    statistics = TopicStatistics(ChannelStatus(9, 5, {"queue_full": 4}))
    assert statistics.of_this_receiver(ChannelStatus(1, 1, {"queue_full": 1})) == ChannelStatus(
        0, 0, {}
    )


def test_messages_lost_before_the_first_arrival_are_gaps() -> None:
    assert recorded(3).gaps == 3


def test_a_repeated_or_older_number_is_refused_and_not_counted() -> None:
    statistics = recorded(10)
    for sequence in (10, 9, 0, 10 - (1 << 31), 10 + (1 << 31)):
        assert not statistics.record(header(sequence), 0, 0)
    assert (statistics.received, statistics.received_bytes, statistics.produced) == (1, 10, 11)
    assert statistics.record(header(10 + (1 << 31) - 1), 0, 0)


def test_numbers_go_on_after_the_largest() -> None:
    statistics = recorded(WRAP - 2, WRAP - 1, WRAP, WRAP + 2)
    assert statistics.gaps == WRAP - 2 + 1
    assert statistics.produced == WRAP + 3


def test_latencies_are_of_the_last_512_messages() -> None:
    statistics = TopicStatistics()
    assert statistics.latency() is None
    for number in range(3000):
        latency_ms = number if number >= 3000 - 512 else -9
        statistics.record(header(number), latency_ms * MS, 0)
    latency = statistics.latency()
    assert latency is not None
    last = range(3000 - 512, 3000)
    assert latency.p50_ms == pytest.approx(np.percentile(last, 50))
    assert latency.p99_ms == pytest.approx(np.percentile(last, 99))
    assert latency.jitter_ms == pytest.approx(1)


@given(st.lists(st.integers(-(10**6), 10**6), min_size=2, max_size=100))
def test_percentiles_interpolate_and_jitter_is_the_mean_change(latencies_ms: list[int]) -> None:
    latency = Latency.of(np.array(latencies_ms, float))
    hundredths = oracle.quantiles(latencies_ms, n=100, method="inclusive")
    changes = [abs(b - a) for a, b in pairwise(latencies_ms)]
    expected = hundredths[49], hundredths[98], oracle.mean(changes)
    assert (latency.p50_ms, latency.p99_ms, latency.jitter_ms) == pytest.approx(expected)


def test_a_single_message_has_no_jitter() -> None:
    assert Latency.of(np.array([3.0])) == Latency(3.0, 3.0, 0.0)


@given(st.integers(0, 3000), st.integers(0, 600))
def test_times_are_of_the_messages_asked_for(end: int, count: int) -> None:
    statistics = TopicStatistics()
    for number in range(end):
        statistics.record(header(number, number, number + 1), number + 2, number + 3)
    numbers = range(max(0, end - min(count, 512)), end)
    rows = statistics.times_ns(max(0, end - count), end)
    assert rows.tolist() == [[number + stage for stage in range(4)] for number in numbers]


def test_a_route_records_when_a_message_was_captured_sent_received_and_published() -> None:
    statistics = TopicStatistics()
    route = Route(lambda _: None, statistics)
    route.receive(Frame(header(0, 1, 2), bytearray(CDR_ENCAPSULATION)), 3, 4)
    assert statistics.times_ns(0, 1).tolist() == [[1, 2, 3, 4]]


def test_times_of_a_malicious_device_are_only_numbers() -> None:
    statistics = TopicStatistics()
    for number, time_ns in enumerate((-(1 << 63), (1 << 63) - 1)):
        assert statistics.record(header(number, time_ns, -time_ns - 1), 1 << 60, 1 << 60)
    latency = statistics.latency()
    assert latency is not None
    assert np.isfinite([latency.p50_ms, latency.p99_ms, latency.jitter_ms]).all()


def test_instances_are_equal_when_they_are_the_same_run() -> None:
    assert Instance("a", "1", topics={"x": TopicStatistics()}) == Instance("a", "1")
    assert Instance("a", "1") != Instance("a", "2")
    assert Instance("a", "1") != Instance("b", "1")

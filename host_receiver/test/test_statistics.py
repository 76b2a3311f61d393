from hypothesis import given
from hypothesis import strategies as st

from ml2_receiver.statistics import Instance, TopicStatistics

WRAP = 1 << 32


def recorded(*sequences: int) -> TopicStatistics:
    statistics = TopicStatistics()
    for sequence in sequences:
        assert statistics.record(sequence % WRAP, 10, 0)
    return statistics


@given(st.sets(st.integers(0, 2000), min_size=1), st.sampled_from([0, WRAP - 1000, 5]))
def test_produced_is_what_arrived_and_what_did_not(kept: set[int], first: int) -> None:
    statistics = TopicStatistics()
    for number in range(max(kept) + 1):
        if number in kept or number == 0:
            assert statistics.record((first + number) % WRAP, 10, 0)
    assert statistics.received == len(kept | {0})
    assert statistics.produced == first + max(kept) + 1
    assert statistics.gaps == statistics.produced - statistics.received


def test_messages_lost_before_the_first_arrival_are_gaps() -> None:
    assert recorded(3).gaps == 3


def test_a_repeated_or_older_number_is_refused_and_not_counted() -> None:
    statistics = recorded(10)
    for sequence in (10, 9, 0, 10 - (1 << 31), 10 + (1 << 31)):
        assert not statistics.record(sequence % WRAP, 10, 0)
    assert (statistics.received, statistics.received_bytes, statistics.produced) == (1, 10, 11)
    assert statistics.record(10 + (1 << 31) - 1, 10, 0)


def test_numbers_go_on_after_the_largest() -> None:
    statistics = recorded(WRAP - 2, WRAP - 1, WRAP, WRAP + 2)
    assert statistics.gaps == WRAP - 2 + 1
    assert statistics.produced == WRAP + 3


def test_latencies_are_of_the_last_512_messages() -> None:
    statistics = TopicStatistics()
    assert statistics.latency() is None
    for number in range(2000):
        statistics.record(number, 0, 1_000_000 * (number if number >= 2000 - 512 else -9))
    latency = statistics.latency()
    assert latency is not None
    assert 2000 - 512 + 255 <= latency.p50_ms <= 2000 - 512 + 256
    assert 1993 <= latency.p99_ms <= 1995


def test_instances_are_equal_when_they_are_the_same_run() -> None:
    assert Instance("a", "1", {"x": TopicStatistics()}) == Instance("a", "1")
    assert Instance("a", "1") != Instance("a", "2")
    assert Instance("a", "1") != Instance("b", "1")

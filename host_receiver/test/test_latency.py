import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ml2_tools.monitoring.latency import TopicLatency

MS = 1_000_000


def row(first: int, messages: int, *shares_ms: float) -> dict[str, str]:
    """Returns the row of the messages from `first` on, as arrive() numbers them."""
    names = ("capture_to_sent", "sent_to_received", "received_to_published")
    shares = zip(names, shares_ms, strict=True)
    return {
        "window.messages": str(messages),
        "window.first_capture_ns": str(first * 100 * MS),
        "window.last_capture_ns": str((first + messages - 1) * 100 * MS),
        **{f"window.{name}_ms": str(ms) for name, ms in shares},
    }


NO_MESSAGES = {"window.messages": "0"}


def arrive(topic: TopicLatency, first: int, *latencies_ms: float) -> None:
    """Messages are captured 100 ms apart, the first at 0."""
    for number, latency_ms in enumerate(latencies_ms, first):
        topic.arrived(number * 100 * MS, number * 100 * MS + round(latency_ms * MS))


def test_a_window_is_of_the_messages_the_receiver_counted() -> None:
    topic = TopicLatency("tf", windows=10)
    arrive(topic, 0, 900, 10, 20, 900)
    topic.reported(row(1, 2, 1, 2, 3))
    assert topic.breakdown() is None, "messages may still be under way"
    topic.reported(NO_MESSAGES)
    breakdown = topic.breakdown()
    assert breakdown is not None
    assert breakdown.messages == 2
    assert breakdown.shares_ms == pytest.approx((1, 2, 3, 15 - 6))
    assert (breakdown.total.p50_ms, breakdown.total.jitter_ms) == pytest.approx((15, 10))


def test_messages_may_arrive_after_the_row_that_counts_them() -> None:
    topic = TopicLatency("tf", windows=10)
    topic.reported(row(0, 1, 1, 2, 3))
    arrive(topic, 0, 7)
    topic.reported(NO_MESSAGES)
    breakdown = topic.breakdown()
    assert breakdown is not None
    assert breakdown.shares_ms == pytest.approx((1, 2, 3, 1))


@pytest.mark.parametrize(
    "window",
    [
        row(-1, 4, 1, 2, 3),  # the first arrived before the subscriber was there
        row(1, 3, 1, 2, 3),  # the last never arrived
        row(0, 3, 1, 2, 3) | {"window.messages": "2"},  # it saw a message more
        row(0, 3, 1, 2, 3) | {"window.messages": "4"},  # it lost one in between
        {"window.messages": "1", "window.last_capture_ns": "0"},  # the device is not synchronised
        NO_MESSAGES,
        {},
    ],
)
def test_a_window_that_cannot_be_compared_does_not_count(window: dict[str, str]) -> None:
    topic = TopicLatency("tf", windows=10)
    arrive(topic, -5, 10, 20, 30)
    arrive(topic, 0, 10, 20, 30)
    topic.reported(window)
    topic.reported(NO_MESSAGES)
    assert topic.breakdown() is None


def test_only_the_last_windows_count() -> None:
    topic = TopicLatency("tf", windows=2)
    for number in range(4):
        arrive(topic, number, 10 * number)
        topic.reported(row(number, 1, number, 0, 0))
    topic.reported(NO_MESSAGES)
    breakdown = topic.breakdown()
    assert breakdown is not None
    assert breakdown.messages == 2
    assert breakdown.shares_ms == pytest.approx((2.5, 0, 0, 22.5))


@given(
    st.lists(st.lists(st.floats(0, 1000), min_size=1, max_size=20), min_size=1, max_size=8),
    st.lists(st.floats(-10, 100), min_size=3, max_size=3),
)
def test_shares_add_up_to_the_mean_of_all_messages(
    windows: list[list[float]], shares_ms: list[float]
) -> None:
    topic, number = TopicLatency("tf", windows=8), 0
    for latencies_ms in windows:
        arrive(topic, number, *latencies_ms)
        topic.reported(row(number, len(latencies_ms), *shares_ms))
        number += len(latencies_ms)
    topic.reported(NO_MESSAGES)
    breakdown = topic.breakdown()
    assert breakdown is not None
    all_ms = np.concatenate(windows)
    assert breakdown.messages == len(all_ms)
    assert breakdown.shares_ms[:3] == pytest.approx(shares_ms, abs=1e-6)
    assert sum(breakdown.shares_ms) == pytest.approx(all_ms.mean(), abs=1e-5)
    assert breakdown.total.p99_ms == pytest.approx(np.percentile(all_ms, 99), abs=1e-5)

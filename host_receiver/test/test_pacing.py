"""Tests what large messages leave to others on a link, in virtual time."""

import pytest

from image_sender import ImageSender
from link_model import SENSORS_MBIT, LinkModel
from ml2_receiver.pacing import Pacing

SEGMENT, JUMBO = 1448, 8948


@pytest.mark.parametrize("segment", [SEGMENT, JUMBO])
@pytest.mark.parametrize("round_trip_ms", [1, 10, 20])
@pytest.mark.parametrize("mbit", [10, 30, 45, 100, 300])
def test_large_messages_fill_a_link_and_have_a_short_queue_in_it(
    mbit: float, round_trip_ms: int, segment: int
) -> None:
    link = LinkModel(mbit, round_trip_ms, segment=segment)
    link.fill(2)
    down, _ = link.fill(0.5)
    assert down > 0.95 * mbit
    # 16 KiB are more than 3 ms of a slow link
    assert link.queue_ms(0.5) < max(3.5, 140 / mbit)
    assert link.queue_ms(0.99) < max(4.5, 170 / mbit)


@pytest.mark.parametrize("segment", [SEGMENT, JUMBO])
@pytest.mark.parametrize("busy", [0, 0.1])
def test_images_on_a_link_of_their_own_leave_the_way_back_to_large_messages(
    busy: float, segment: int
) -> None:
    link = LinkModel(30, 10, busy=busy, segment=segment)
    ImageSender(link, wanted_mbit=60)
    link.fill(4)
    down, images = link.fill(4)
    assert down > 0.7 * 30
    assert images > 0.6 * (30 - SENSORS_MBIT)
    assert link.queue_ms(0.5) < 4
    assert link.queue_ms(0.99) < 7


@pytest.mark.parametrize("segment", [SEGMENT, JUMBO])
def test_acknowledgements_that_wait_up_to_20_ms_on_the_uplink_do_not_lower_the_rate(
    segment: int,
) -> None:
    link = LinkModel(30, 10, radio_ms=20, segment=segment)
    link.fill(2)
    down, _ = link.fill(3)
    assert down > 0.7 * 30
    assert link.queue_ms(0.5) < 5


@pytest.mark.parametrize("busy", [0, 0.1])
def test_both_directions_use_most_of_a_link_that_they_share(busy: float) -> None:
    link = LinkModel(100, 10, is_shared=True, busy=busy)
    ImageSender(link, wanted_mbit=205)
    link.fill(5)
    down, images = link.fill(5)
    assert down + images > 0.85 * (100 - SENSORS_MBIT)
    assert images > 40
    assert down > 15
    assert link.queue_ms(0.5) < 6


def test_a_link_that_becomes_slower_has_a_short_queue_soon() -> None:
    link = LinkModel(100, 10)
    link.fill(2)
    link.down.rate /= 10
    link.fill(1)
    link.fill(1)
    assert link.queue_ms(0.99) < 25


def test_rests_between_messages_do_not_slow_them() -> None:
    link = LinkModel(300, 10)
    for _ in range(20):
        began_s = link.now_s
        link.fill(0.001, 300_000)
        took_s = link.now_s - began_s
        link.rest(0.5)
    assert took_s < 0.06


class _Connection:
    """A connection that keeps what it sends, and counts how often it is asked for that."""

    def __init__(self) -> None:
        self.kept_bytes = self.asked = 0

    def send_all(self, data: bytes | memoryview) -> None:
        self.kept_bytes += len(data)

    def unacknowledged(self) -> int:
        self.asked += 1
        return self.kept_bytes

    def least_round_trip_s(self) -> float:
        return 0.01


def test_a_connection_is_asked_while_it_has_bytes_under_way() -> None:
    pacing = Pacing(lambda: False, lambda: 0.0, lambda _: None)
    first, second = _Connection(), _Connection()
    pacing.send(b"message", first)
    pacing.send(b"message", second)
    assert first.asked == 1
    first.kept_bytes = 0
    for _ in range(3):
        pacing.send(b"message", second)
    assert (first.asked, second.asked) == (2, 3)

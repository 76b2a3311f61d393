"""Both directions of a link between receiver and headset, in virtual time."""

import heapq
import random
from collections.abc import Callable
from functools import partial
from typing import Protocol

from ml2_receiver.pacing import Pacing

BYTES_PER_MBIT = 125e3
SENSORS_MBIT = 9
_TLS_BYTES, _HEADERS_BYTES, _SMALL_BYTES = 22, 40, 100
_TICK_S, _ASK_S, _RADIO_S, _ACKNOWLEDGE_S = 0.001, 0.02, 0.01, 0.04
_MESSAGE_BYTES = 1_000_000


class Exchanges(Protocol):
    """Is told of the exchanges of the time lane."""

    def asked(self) -> None: ...

    def answered(self, round_trip_s: float, there_s: float) -> None: ...


class _Bucket:
    """A rate in B/s, and a queue until `free_s`; both directions may share it."""

    def __init__(self, rate: float) -> None:
        self.rate, self.free_s = rate, 0.0

    def passed(self, length: float, now_s: float) -> float:
        """Returns when so many bytes will have passed."""
        self.free_s = max(self.free_s, now_s) + length / self.rate
        return self.free_s


class LinkModel:
    """A link with a rate and a queue for each direction, or one for both, as in the air of Wi-Fi.

    Sensors use some of the uplink, and acknowledgements and requests of the time wait in it. TCP
    acknowledges when more than a segment has arrived, and what is left after 40 ms.

    Args:
        radio_ms: for up to so long, anew each 10 ms, the radio withholds what the headset sends.
        busy: this part of the receiver's sleeps takes up to 5 ms longer.
    """

    def __init__(
        self,
        mbit: float,
        round_trip_ms: float,
        *,
        is_shared: bool = False,
        radio_ms: float = 0.0,
        busy: float = 0.0,
        segment: int = 1448,
    ) -> None:
        self.up = _Bucket(mbit * BYTES_PER_MBIT)
        self.down = self.up if is_shared else _Bucket(mbit * BYTES_PER_MBIT)
        self.now_s, self.arrived, self.images_arrived = 0.0, 0, 0.0
        self.exchanges: Exchanges | None = None
        self.queues_s: list[float] = []
        self._path_s, self._segment = round_trip_ms / 1e3, segment
        self._radio_s, self._busy = radio_ms / 1e3, busy
        self._random, self._withheld = random.Random(1), (-1, 0.0)
        self._up_arrival_s = 0.0
        self._written = self._acknowledged = self._unanswered = 0
        self._events: list[tuple[float, int, Callable[[], None]]] = []
        self._count = 0
        self.pacing = Pacing(lambda: False, lambda: self.now_s, self._sleep)
        self._tick()
        self._ask()

    def fill(self, seconds: float, message_bytes: int = _MESSAGE_BYTES) -> tuple[float, float]:
        """Sends messages; returns the rates of messages and of images in Mbit/s."""
        self.queues_s.clear()
        began_s, arrived, images = self.now_s, self.arrived, self.images_arrived
        while self.now_s < began_s + seconds:
            self.pacing.send(bytes(message_bytes), self)
        unit = BYTES_PER_MBIT * (self.now_s - began_s)
        return (self.arrived - arrived) / unit, (self.images_arrived - images) / unit

    def queue_ms(self, part: float) -> float:
        """Returns the downlink's queue that this part of the time of fill() did not exceed."""
        return 1e3 * sorted(self.queues_s)[int(part * len(self.queues_s))]

    def at(self, time_s: float, event: Callable[[], None]) -> None:
        """Has an event happen at a time."""
        self._count += 1
        heapq.heappush(self._events, (time_s, self._count, event))

    def rest(self, seconds: float) -> None:
        """Lets time pass."""
        end_s = self.now_s + seconds
        while self._events and self._events[0][0] <= end_s:
            self.now_s, _, event = heapq.heappop(self._events)
            event()
        self.now_s = end_s

    def send_all(self, data: bytes | memoryview) -> None:
        record = len(data) + _TLS_BYTES
        self._written += record
        for begin in range(0, record, self._segment):
            segment = min(self._segment, record - begin)
            self._put_down(segment + _HEADERS_BYTES, partial(self._arrive, segment))

    def unacknowledged(self) -> int:
        return self._written - self._acknowledged

    def least_round_trip_s(self) -> float:
        return self._path_s

    def send_image(self, length: float, acknowledged: Callable[[], None]) -> None:
        """Sends a part of an image to the receiver."""

        def arrived() -> None:
            self.images_arrived += length
            self._put_down(_SMALL_BYTES, acknowledged)

        self._put_up(length, arrived)

    def _sleep(self, seconds: float) -> None:
        late = self._random.random() < self._busy
        self.rest(seconds + (self._random.uniform(0, 0.005) if late else 0))

    def _put_down(self, length: float, arrived: Callable[[], None]) -> None:
        self.at(self.down.passed(length, self.now_s) + self._path_s / 2, arrived)

    def _put_up(self, length: float, arrived: Callable[[], None]) -> None:
        passed_s = self.up.passed(length, self.now_s)
        period = int(self.now_s / _RADIO_S)
        if self._withheld[0] != period:
            self._withheld = period, self._random.uniform(0, self._radio_s)
        arrival_s = passed_s + self._path_s / 2 + self._withheld[1]
        self._up_arrival_s = max(self._up_arrival_s, arrival_s)
        self.at(self._up_arrival_s, arrived)

    def _tick(self) -> None:
        self.queues_s.append(max(0.0, self.down.free_s - self.now_s))
        self._put_up(SENSORS_MBIT * BYTES_PER_MBIT * _TICK_S, lambda: None)
        self.at(self.now_s + _TICK_S, self._tick)

    def _ask(self) -> None:
        asked_s = self.now_s

        def arrived() -> None:
            there_s = self.now_s - asked_s
            self.pacing.requested(there_s + 1000)
            self._put_down(_SMALL_BYTES, lambda: answered(there_s))

        def answered(there_s: float) -> None:
            if self.exchanges:
                self.exchanges.answered(self.now_s - asked_s, there_s)
            self.at(max(self.now_s, asked_s + _ASK_S), self._ask)

        if self.exchanges:
            self.exchanges.asked()
        self._put_up(_SMALL_BYTES, arrived)

    def _arrive(self, segment: int) -> None:
        self.arrived += segment
        self._unanswered += segment
        arrived = self.arrived
        if self._unanswered > self._segment:
            self._acknowledge(arrived)
        else:
            self.at(self.now_s + _ACKNOWLEDGE_S, lambda: self._acknowledge_last(arrived))

    def _acknowledge_last(self, arrived: int) -> None:
        if self._unanswered and arrived == self.arrived:
            self._acknowledge(arrived)

    def _acknowledge(self, arrived: int) -> None:
        self._unanswered = 0
        self._put_up(_SMALL_BYTES, lambda: self._acknowledged_to(arrived))

    def _acknowledged_to(self, arrived: int) -> None:
        self._acknowledged = max(self._acknowledged, arrived)

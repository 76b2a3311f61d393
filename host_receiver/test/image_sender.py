"""The headset's images in virtual time: the rules of ARCHITECTURE.md, Pacing, in a shorter form."""

from collections import deque
from functools import partial
from math import exp2, inf

from link_model import BYTES_PER_MBIT, LinkModel

_FRAME_S, _BURST_S, _POLL_S, _SLICE_BYTES = 1 / 30, 0.02, 0.0005, 16 << 10
_LEAST_RATE, _START_RATE = 0.5 * BYTES_PER_MBIT, 10 * BYTES_PER_MBIT
_PLATEAU_S = 1 + 1.5 ** (1 / 3)
# The cameras' parts of all bytes, and their phases in s.
_CAMERAS = ((0.5, 0.003), (0.06, 0.011), (0.29, 0.008), (0.15, 0.018))


class ImageSender:
    """Images of several cameras, 30 times a second, that share a rate and give way to the link.

    Adaptation takes 15 % away once a second while images are lost, and gives as much back after 5 s
    without a wait.

    Args:
        wanted_mbit: what the images need before they give way.
    """

    def __init__(self, link: LinkModel, wanted_mbit: float) -> None:
        self._link = link
        link.exchanges = self
        self._wanted = self._present = wanted_mbit * BYTES_PER_MBIT
        self._waiting = self._written = self._acknowledged = 0.0
        self._totals = deque([(0.0, 0.0, 0.0)])  # time in s, bytes sent, and acknowledged
        self._congested_at: float | None = None
        self._cut_rate, self._cuts = 0.0, 0
        self._drained_s = self._held_until_s = self._advanced_s = self._next_s = 0.0
        self._grown_s = self._delay_s = self._return_s = 0.0
        self._queued = 0
        self._least_round_trip_s = self._least_there_s = 10.0
        self._waited_s = self._lost_s = self._adapted_s = self._backlog_s = -1.0
        self._busy_since_s, self._paused_s = 0.0, 0.0
        self._is_behind_images = False
        for part, phase_s in _CAMERAS:
            link.at(0.5 + phase_s, partial(self._capture, part))
        link.at(0.5, self._step)

    def asked(self) -> None:
        self._is_behind_images = self._written - self._acknowledged > 2 * 1460

    def answered(self, round_trip_s: float, there_s: float) -> None:
        self._least_round_trip_s = min(self._least_round_trip_s, round_trip_s)
        self._least_there_s = min(self._least_there_s, there_s)
        found_s = there_s - self._least_there_s
        self._return_s = max(0.0, round_trip_s - self._least_round_trip_s - found_s)
        if not self._is_behind_images:
            return
        before_s, self._delay_s = self._delay_s, found_s
        self._queued = self._queued + 1 if found_s > self._tolerated_s / 2 else 0
        if min(found_s, before_s) > self._tolerated_s and self._link.now_s >= self._held_until_s:
            self._cut(found_s + max(0.0, found_s - before_s))

    @property
    def _tolerated_s(self) -> float:
        return max(0.006, self._least_round_trip_s / 8)

    def _cut(self, delay_s: float) -> None:
        now_s, rate = self._link.now_s, self._rate()
        _, delivered = self._greatest()
        known = self._congested_at or 0.0
        if now_s - self._held_until_s < 0.3 + 2 * self._least_round_trip_s and self._cuts < 4:
            self._cuts += 1
            self._congested_at = max(_LEAST_RATE, self._cut_rate * 0.8**self._cuts)
        else:
            if self._is_filled or rate > 1.1 * known:
                known = 0.0
            self._congested_at = min(max(delivered, known, rate / 4), rate)
            self._cut_rate, self._cuts = self._congested_at, 0
        self._drained_s = now_s + 2 * delay_s
        self._held_until_s = self._drained_s + 2 * self._least_round_trip_s + 0.04
        self._grown_s = self._delay_s = 0.0

    @property
    def _is_filled(self) -> bool:
        return self._paused_s < 0 and self._link.now_s - self._busy_since_s > 0.1

    def _greatest(self) -> tuple[float, float]:
        """Returns the greatest rates of 20 ms in the last 400 ms, of sending and of delivery."""
        rates, before = [(0.0, 0.0)], deque[tuple[float, float, float]]()
        for total in self._totals:
            time_s, sent, acknowledged = total
            before.append(total)
            while len(before) > 1 and time_s - before[1][0] >= _BURST_S:
                before.popleft()
            first_s, first_sent, first_acknowledged = before[0]
            passed_s = max(time_s - first_s, _BURST_S)
            rates.append(
                ((sent - first_sent) / passed_s, (acknowledged - first_acknowledged) / passed_s)
            )
        return max(it for it, _ in rates), max(it for _, it in rates)

    def _rate(self) -> float:
        now_s = self._link.now_s
        from_s = max(self._advanced_s, self._drained_s)
        if now_s > from_s and now_s - self._waited_s < 0.05:
            self._grown_s += (now_s - from_s) / self._slowness()
        self._advanced_s = now_s
        if self._congested_at is None:
            return _START_RATE * exp2(self._grown_s / 0.2)
        beyond_s = self._grown_s - _PLATEAU_S
        part = 0.95 + 0.1 * (self._grown_s - 1) ** 3
        if now_s < self._drained_s:
            part = 0.25
        elif beyond_s > 0:
            part = 1.1 * exp2(beyond_s / 0.4)
        return max(_LEAST_RATE, self._congested_at * part)

    def _slowness(self) -> float:
        if self._congested_at is None or self._grown_s < _PLATEAU_S:
            return 1
        sent, delivered = self._greatest()
        if delivered + 0.8e6 < 0.9 * sent:
            return inf
        if self._queued >= 3:
            return 25
        return 1 if self._is_filled else 5 if self._present < self._wanted else 25

    def _capture(self, part: float) -> None:
        if self._waiting > 4 * self._present * _FRAME_S:
            self._lost_s = self._link.now_s
        else:
            self._waiting += self._present * part * _FRAME_S
        self._link.at(self._link.now_s + _FRAME_S, partial(self._capture, part))

    def _adapt(self) -> None:
        now_s = self._link.now_s
        if self._waiting > self._present * _FRAME_S:
            self._backlog_s = now_s
        if now_s - self._adapted_s > 1 and now_s - self._lost_s < 0.2:
            self._present, self._adapted_s = self._present * 0.85, now_s
        elif now_s - max(self._backlog_s, self._adapted_s) > 5:
            self._present, self._adapted_s = min(self._wanted, self._present * 1.15), now_s

    def _step(self) -> None:
        now_s = self._link.now_s
        self._adapt()
        if now_s - self._totals[-1][0] >= 0.002:
            self._totals.append((now_s, self._written, self._acknowledged))
            while now_s - self._totals[0][0] > 0.4:
                self._totals.popleft()
        if self._waiting > 0 and self._paused_s >= 0:
            if now_s - self._paused_s > 0.005:
                self._busy_since_s = now_s
            self._paused_s = -1.0
        while self._waiting > 0 and self._may_write():
            self._write()
        if self._waiting <= 0 and self._paused_s < 0:
            self._paused_s = now_s
        self._link.at(now_s + _POLL_S, self._step)

    def _may_write(self) -> bool:
        if self._next_s > self._link.now_s:
            self._waited_s = self._link.now_s
            return False
        rate = self._rate()
        proven = min(rate, (self._congested_at or rate) * 1.1)
        most = rate * (self._least_round_trip_s + self._return_s)
        most += proven * (self._tolerated_s + 0.002)
        under_way = self._written - self._acknowledged
        return _SLICE_BYTES + under_way <= max(_SLICE_BYTES, most)

    def _write(self) -> None:
        length = min(_SLICE_BYTES, self._waiting)
        self._next_s = max(self._next_s, self._link.now_s - 0.001) + length / self._rate()
        self._waiting -= length
        self._written += length
        self._link.send_image(length, lambda: self._acknowledge(length))

    def _acknowledge(self, length: float) -> None:
        self._acknowledged += length

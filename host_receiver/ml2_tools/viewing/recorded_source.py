"""Plays a recording for the page, without ROS."""

import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from ml2_receiver.errors import RecordingError
from ml2_receiver.json_text import json_text
from ml2_receiver.table.reader import load_table

from ..bags.bag_reader import BagMessage
from ..bags.decoding import decoder
from ..bags.indexed_bag import History, IndexedBag
from ..geometry.transform_tree import STATIC_DEPTH
from ..monitoring.topic_table import Rows
from ..playback.timeline import Timeline
from .plots import CLOCK, THROUGHPUT
from .requests import (
    FASTEST,
    SLOWEST,
    AllowedRequests,
    BackendRequest,
    Newest,
    Outcome,
    Play,
    Seek,
    Speed,
)
from .scene import TF, TRANSFORMS
from .state import Levels, recorded_state
from .subscription import Kind, Subscription
from .view import View

_NANOS = 1_000_000_000
_PERIOD_S = 0.5
# Messages that nobody sees are passed together.
_SLACK_S = 0.1
# Playing slower than asked for is better than leaving out what is late.
_MOST_LATE_S = 0.5
# Long enough for the transforms of an image, which come before it.
_LEAD_NS = _NANOS // 2
_HISTORIES = {
    Kind.IMAGE: History(1, 0),
    Kind.SENSOR: History(200, _LEAD_NS),
    Kind.TRANSFORMS: History(200, _LEAD_NS),
    Kind.EVENTS: History(100, None),
    Kind.LATCHED: History(1, 0),
    Kind.STATIC: History(STATIC_DEPTH, None),
}


class RecordedSource:
    """A recording, as a Source and as a Backend.

    A thread of its own plays it. A jump shows the newest message of each topic at that time.

    Attributes:
        left_out: what the recording has and is not shown, in words.
        apart: where it may be another recording, in words.

    Raises:
        RecordingError: the recording cannot be read.
    """

    def __init__(self, path: Path, headset: str | None = None) -> None:
        self._bag = IndexedBag(path, headset)
        self._begin_ns, self._end_ns = self._bag.begin_ns, self._bag.end_ns
        self._length_s = (self._end_ns - self._begin_ns) / _NANOS
        self.allowed = AllowedRequests(length_s=self._length_s)
        self._facts = {
            "recording": path.resolve().name,
            "headset": self._bag.config.headset,
            "length": f"{self._length_s:.0f} s",
            "size": f"{self._bag.size_bytes / 1e6:.1f} MB",
        }
        self.left_out, self.apart = self._bag.left_out, self._bag.apart
        self._timeline = Timeline(self._begin_ns, self._begin_ns, 1, is_paused=False)
        # All messages until this time were shown.
        self._shown_ns = self._begin_ns
        self._rows, self._rates_hz = self._topics()
        self._lock = threading.Lock()
        self._subscriptions: dict[str, list[Subscription]] = {}
        self._added: list[Subscription] = []
        self._woken = threading.Event()
        self._is_over = False
        self._position: Newest = 0, ""
        self._next_report_s = 0.0

    @property
    def receiver(self) -> str:
        """The --name of the receiver that recorded, which is before each frame id; empty if none.

        The prefix of topics does not tell it, since `topic_name` may have a slash itself.
        """
        if self._bag.types.get(TF) != TRANSFORMS:
            return ""
        payload = next((it.payload for it in self._bag.messages() if it.topic == TF), b"")
        with suppress(ValueError):
            (first, *_) = decoder(TRANSFORMS)(payload).transforms
            return str(first.child_frame_id.rpartition("/")[0])
        return ""

    def start(self, view: View) -> None:
        self._view = view
        for name in (CLOCK, THROUGHPUT):  # /diagnostics is not recorded
            del view.series[name]
        self._thread = threading.Thread(target=self._run, name="view-playback")
        self._thread.start()

    def close(self) -> None:
        self._is_over = True
        self._woken.set()
        self._thread.join()

    def now_s(self) -> float:
        return (self._timeline.now_ns() - self._begin_ns) / _NANOS

    def unix_s(self, at_s: float) -> float:
        return self._begin_ns / _NANOS + at_s

    def add(self, subscription: Subscription) -> None:
        with self._lock:
            self._subscriptions.setdefault(subscription.topic, []).append(subscription)
            self._added.append(subscription)
        self._woken.set()

    def remove(self, subscription: Subscription) -> None:
        with self._lock:
            self._subscriptions[subscription.topic].remove(subscription)

    def state(self, rows: Rows, levels: Levels, modes: Mapping[str, str], battery: str) -> Any:
        return recorded_state(rows, {**self._facts, "battery": battery}, self._rates_hz, modes)

    def described(self) -> dict[str, Any]:
        speeds = [SLOWEST, 0.5, 1, 2, FASTEST]
        times = {"begin_s": self._begin_ns / _NANOS, "length_s": self._length_s}
        return {"recording": {**times, "speeds": speeds}}

    def sources(self) -> Iterable[tuple[str, Callable[[], Newest]]]:
        return [("position", lambda: self._position)]

    def submit(self, request: BackendRequest, answered: Callable[[Outcome], None]) -> None:
        """Carries out a Play, Seek or Speed at once."""
        match request:
            case Play(is_playing):
                if is_playing and self._timeline.now_ns() >= self._end_ns:
                    self._timeline.jump(self._begin_ns)
                self._timeline.pause(not is_playing)
            case Seek(offset_s):
                self._timeline.jump(self._begin_ns + round(offset_s * _NANOS))
            case Speed(rate):
                self._timeline.set_rate(rate)
        self._woken.set()
        self._say_position()  # so that no earlier one is sent after the answer
        answered(Outcome("recording", True, ""))

    def _topics(self) -> tuple[Rows, Mapping[str, float]]:
        """Returns the topics in the form of rows of /diagnostics, and their mean rates in Hz."""
        bag = self._bag
        known = {
            it.full_name(bag.prefix): (stream.id, it.type)
            for stream in load_table().streams.values()
            for it in stream.topics
        }
        rows = {
            name: {"stream": stream, "type": type}
            for name, (stream, type) in known.items()
            if bag.types.get(name) == type and bag.counts[name]
        }
        session = {f"state.{it['stream']}": "running" for it in rows.values()}
        rates_hz = {it: bag.counts[it] / self._length_s for it in rows if self._length_s}
        return {"session": session, **rows}, rates_hz

    def _run(self) -> None:
        while not self._is_over:
            jumps, from_ns = self._timeline.position
            try:
                self._jump(from_ns)
                self._play(jumps)
            except Exception as error:
                self._timeline.pause()
                if not isinstance(error, RecordingError):
                    self._view.faults.add("the rest of the recording", error)
                self._view.fail(str(error) if isinstance(error, RecordingError) else repr(error))
                while not self._is_elsewhere(jumps):
                    self._woken.wait()
                    self._woken.clear()

    def _jump(self, to_ns: int) -> None:
        """Shows what was the newest at a time."""
        with self._lock:
            self._added.clear()
            subscriptions = [it for them in self._subscriptions.values() for it in them]
        messages = self._bag.until(to_ns, {it.topic: _HISTORIES[it.kind] for it in subscriptions})
        self._view.forget()
        self._shown_ns = to_ns
        for message in messages:
            self._deliver(message)
        self._report()

    def _play(self, jumps: int) -> None:
        """Plays on until a jump, or until this object is closed."""
        for message in self._bag.after(self._shown_ns):
            while not self._is_due(message, jumps):
                if self._is_elsewhere(jumps):
                    return
            self._deliver(message)
            self._shown_ns = message.time_ns
        self._timeline.hold(self._end_ns)
        self._timeline.pause()
        self._report()
        while not self._is_elsewhere(jumps):
            self._wait(_PERIOD_S)

    def _is_due(self, message: BagMessage, jumps: int) -> bool:
        """Returns True if a message is to be shown; else waits for a moment first."""
        if self._view.is_watched:
            self._timeline.start(jumps)
        else:
            self._timeline.hold(self._timeline.now_ns())
        left_s = self._timeline.left_s(message.time_ns)
        slack_s = 0 if self._subscriptions.get(message.topic) else _SLACK_S
        if left_s is None or left_s > slack_s or self._woken.is_set():
            self._wait(_PERIOD_S if left_s is None else min(max(left_s, 0), _PERIOD_S))
            return False
        if left_s < -_MOST_LATE_S:
            self._timeline.hold(message.time_ns)
        if time.monotonic() >= self._next_report_s:
            self._report()
        return True

    def _is_elsewhere(self, jumps: int) -> bool:
        return self._is_over or self._timeline.position[0] != jumps

    def _wait(self, timeout_s: float) -> None:
        """Waits until something was asked for, and shows what was added meanwhile."""
        if self._woken.wait(timeout_s):
            self._woken.clear()
            with self._lock:
                added, self._added = self._added, []
            topics = {it.topic: _HISTORIES[it.kind] for it in added}
            for message in self._bag.until(self._shown_ns, topics) if topics else ():
                self._deliver(message)
            self._report()
        elif time.monotonic() >= self._next_report_s:
            self._report()

    def _deliver(self, message: BagMessage) -> None:
        with self._lock:
            subscriptions = list(self._subscriptions.get(message.topic, ()))
        for subscription in subscriptions:
            subscription.take(message.payload, (message.time_ns - self._begin_ns) / _NANOS)

    def _report(self) -> None:
        self._next_report_s = time.monotonic() + _PERIOD_S
        self._view.report(self._rows, {})
        self._say_position()

    def _say_position(self) -> None:
        with self._view.changed:
            position = {
                "type": "position",
                "at_s": min(self.now_s(), self._length_s),
                "rate": self._timeline.rate,
                "is_playing": not self._timeline.is_paused,
                "jumps": self._timeline.position[0],
            }
            self._position = self._position[0] + 1, json_text(position)
            self._view.changed.notify_all()

"""Images, 3D view, plots and state of one source, for browsers."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any, Protocol

from ml2_receiver.json_text import json_text
from ml2_receiver.printable import printable
from ml2_receiver.topics.plain_messages import decode_string

from ..bags.decoding import decoder
from ..live.faults import Faults
from ..monitoring.topic_table import Rows
from .cloud import CLOUD, Cloud
from .fields import TopicField, plottable_topics, topic_fields
from .full_image import FullImage, full_name
from .log import Log
from .newest_image import NewestImage
from .plots import SENSOR_PLOTS, UNITS, Series
from .scene import SCENE, TF, TF_STATIC, Scene
from .state import (
    Levels,
    image_streams,
    known_topics,
    mode_in_words,
    published_images,
    topic_prefix,
)
from .subscription import Kind, Subscription

_BATTERY, _CONFIG, _LOG = "battery", "config", "log"
_MOST_NAMED, _WARN = 5, 1


class Source(Protocol):
    """Messages and state for one view. Thread-safe."""

    def start(self, view: View) -> None:
        """Reports rows to the view from now on; may do so at once, and in any thread."""

    def close(self) -> None:
        """Ends its threads; no method may be called afterwards."""

    def now_s(self) -> float:
        """Returns the present time of its clock in s, whose zero means nothing."""

    def unix_s(self, at_s: float) -> float:
        """Returns a time of its clock in s since 1970."""

    def add(self, subscription: Subscription) -> None:
        """Begins to take the messages of a topic; in a thread of its own."""

    def remove(self, subscription: Subscription) -> None:
        """Ends what add() began."""

    def state(self, rows: Rows, levels: Levels, modes: Mapping[str, str], battery: str) -> Any:
        """Returns the state that the page shows, as an object for JSON.

        Args:
            rows, levels: what was reported last.
            modes: the mode of each camera in words.
            battery: the charge of the battery in words.
        """


class View:
    """Images, poses, values and state of one source, kept for browsers. Thread-safe.

    The source's threads bring the messages. It gets images while a browser shows them, and other
    messages while there is a browser.

    Args:
        receiver: the receiver's --name, or empty.
        with_eyes: True if browsers may ask for images of eye cameras.

    Attributes:
        changed: notified when there is a new image or a new state.
        streams: the streams whose images browsers may ask for.
        images: the newest image of each stream, and that in full size by full_name().
        scene: the poses of the 3D view.
        cloud: the points of the 3D view.
        log: the events of the topic `log`.
        series: the values of each plot.
        faults: what was left out because a message or a report is none that was foreseen.
    """

    def __init__(self, source: Source, receiver: str, with_eyes: bool) -> None:
        self._source = source
        self.changed = threading.Condition()
        self.streams = image_streams(with_eyes)
        self.full = {full_name(it): FullImage(it) for it in self.streams}
        self.images = {it: NewestImage(it) for it in self.streams} | self.full
        self.scene = Scene(receiver)
        self.cloud = Cloud(self.scene)
        self.log = Log()
        self.series = {name: Series() for name in UNITS}
        self.faults = Faults()
        self._state: tuple[int, str] = 0, ""
        self._rows: Rows = {}
        self._modes: dict[str, str] = {}
        self._battery = "not reported"
        self._watched: dict[object, frozenset[str]] = {}
        # The topics that have something to plot.
        self._types: Mapping[str, str] = {}
        self._fields: Mapping[str, TopicField] = {}
        self._in_scene: Mapping[str, tuple[str, str]] = {}
        # The subscriptions, by the part of the view that they fill and their topic.
        self._subscriptions: dict[tuple[str, str], Subscription] = {}
        self._settling = threading.Lock()
        source.start(self)

    def close(self) -> None:
        """Closes the source; no method may be called afterwards."""
        self._source.close()

    @property
    def offered(self) -> Set[str]:
        """The streams, parts of the 3D view, and fields of topics that browsers may ask for."""
        return self.images.keys() | {SCENE, CLOUD} | self._fields.keys()

    @property
    def rows(self) -> Rows:
        """The latest report of the source, in the form of rows of /diagnostics."""
        return self._rows

    @property
    def is_watched(self) -> bool:
        """True while a browser is connected."""
        return bool(self._watched)

    @property
    def state(self) -> tuple[int, str]:
        """The number of the newest state, from 1, and its JSON; 0 before the first."""
        return self._state

    @property
    def now_s(self) -> float:
        """The present time on the clock of plots and poses."""
        return self._source.now_s()

    def watch(self, browser: object, streams: frozenset[str] | None) -> None:
        """Sets what of `offered` a browser shows; None once the browser is gone."""
        with self._settling:
            if streams is None:
                self._watched.pop(browser, None)
            else:
                self._watched[browser] = streams
            self._settle()

    def report(self, rows: Rows, levels: Levels) -> None:
        """Takes what the source says of its topics, in the form of rows of /diagnostics."""
        try:
            with self._settling:
                self._rows = rows
                if (types := plottable_topics(rows)) != self._types:
                    self._types, self._fields = types, topic_fields(types)
                self._settle()
            state = self._source.state(rows, levels, self._modes, self._battery)
        except Exception as error:  # the next report may be another one
            self.faults.add("a report", error)
            self.fail(f"the report of the receiver cannot be shown: {error!r}")
        else:
            state["warnings"] += self._left_out()
            state["topics"] = self._types
            self._show(state)

    def _left_out(self) -> list[dict[str, Any]]:
        counts = list(self.faults.counts().items())[:_MOST_NAMED]
        return [
            {"row": "left out", "text": f"{count} times {reason}", "level": _WARN}
            for reason, count in counts
        ]

    def fail(self, problem: str) -> None:
        """Shows instead of the state why there is none."""
        self._show({"type": "state", "problem": printable(problem)})

    def forget(self) -> None:
        """Forgets all messages: the next ones may be of any time."""
        for image in self.images.values():
            image.forget()
        self.scene.forget()
        self.cloud.forget()
        self.log.forget()
        for series in self.series.values():
            series.forget()

    def _show(self, state: Any) -> None:
        with self.changed:
            self._state = self._state[0] + 1, json_text(state)
            self.changed.notify_all()

    def _settle(self) -> None:
        """Follows what is watched and published, and nothing else."""
        wanted = self._wanted() if self._watched else {}
        for key in self._subscriptions.keys() - wanted.keys():
            self._source.remove(self._subscriptions.pop(key))
            if (name := key[0]) in self.images:  # nobody may see an old image as a new one
                self.images[name].forget()
            if name not in UNITS:
                self.series.pop(name, None)
        for key in wanted.keys() - self._subscriptions.keys():
            self._subscriptions[key] = self._subscription(*key, wanted[key])
            self._source.add(self._subscriptions[key])

    def _wanted(self) -> dict[tuple[str, str], str]:
        """Returns the types of the wanted topics, by what they fill and their name."""
        shown = frozenset[str]().union(*self._watched.values())
        found = {
            name: topic
            for stream, topic in published_images(self._rows).items()
            for name in {stream, full_name(stream)} & shown & self.images.keys()
        }
        topics = {it.stream: (name, it.type) for name, it in known_topics(self._rows).items()}
        for plot in SENSOR_PLOTS.values():
            if (stream := next((it for it in plot.streams if it in topics), None)) is not None:
                found[plot.name] = topics[stream]
        if _BATTERY in topics:
            found[_BATTERY] = topics[_BATTERY]
        if SCENE in shown:
            self._in_scene = self.scene.topics(self._rows, shown)
            found |= self._in_scene
        found |= {it: self._fields[it].topic_and_type for it in shown & self._fields.keys()}
        if (prefix := topic_prefix(self._rows)) is not None:
            found |= {it: (f"{prefix}/{it}", "std_msgs/msg/String") for it in (_CONFIG, _LOG)}
        return {(name, topic): type for name, (topic, type) in found.items()}

    def _subscription(self, name: str, topic: str, type: str) -> Subscription:
        subscription = self._subscription_of(name, topic, type)

        def take(payload: bytes, at_s: float) -> None:
            try:
                subscription.take(payload, at_s)
            except Exception as error:  # the thread of the source must go on
                self.faults.add(f"a message of {topic}", error)

        return replace(subscription, take=take)

    def _subscription_of(self, name: str, topic: str, type: str) -> Subscription:
        if name in self.images:
            return Subscription(topic, type, Kind.IMAGE, partial(self._take_image, name, type))
        if name in self._in_scene:
            kind = {TF: Kind.TRANSFORMS, TF_STATIC: Kind.STATIC}.get(topic, Kind.SENSOR)
            return Subscription(topic, type, kind, partial(self.scene.take, name, type))
        if name == _CONFIG:
            return Subscription(topic, type, Kind.LATCHED, self._configured)
        if name == _LOG:
            return Subscription(topic, type, Kind.EVENTS, self._logged)
        if name == _BATTERY:
            return Subscription(topic, type, Kind.SENSOR, partial(self._charged, decoder(type)))
        if name in SENSOR_PLOTS:
            read = SENSOR_PLOTS[name].read
        else:
            self.series[name] = Series()
            read = self._fields[name].read
        return Subscription(topic, type, Kind.SENSOR, partial(self._add, name, read, decoder(type)))

    def _take_image(self, stream: str, type: str, payload: bytes, _: float) -> None:
        if self.images[stream].take(type, payload):
            with self.changed:
                self.changed.notify_all()

    def _add(
        self,
        name: str,
        read: Callable[[Any], Sequence[float]],
        decode: Callable[[bytes], Any],
        payload: bytes,
        at_s: float,
    ) -> None:
        if (series := self.series.get(name)) is None:
            return  # no browser shows it any more
        # A headset's bytes that are not of the type must not end the thread.
        with suppress(ValueError):
            if series.is_due(at_s):
                series.add(read(decode(payload)), at_s)

    def _charged(self, decode: Callable[[bytes], Any], payload: bytes, _: float) -> None:
        with suppress(ValueError):
            share = decode(payload).percentage
            self._battery = f"{share * 100:.0f} %" if math.isfinite(share) else self._battery

    def _logged(self, payload: bytes, at_s: float) -> None:
        with suppress(ValueError):
            words = decode_string(payload).decode(errors="replace")
            self.log.add(self._source.unix_s(at_s), words)

    def _configured(self, payload: bytes, _: float) -> None:
        with suppress(ValueError, KeyError, AttributeError, TypeError, RecursionError):
            streams = json.loads(decode_string(payload))["streams"]
            values = {stream: answer.get("values") for stream, answer in streams.items()}
            self._modes = {stream: mode_in_words(it) for stream, it in values.items()}

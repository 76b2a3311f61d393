"""Sends the messages of a recording when they are due."""

import threading
from collections.abc import Callable

from ml2_receiver.errors import RecordingError
from ml2_receiver.generated.message_definitions import DEFINITIONS
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.stamps import stamp_reader
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, LaneKind, max_data_bytes

from ..bags.bag_reader import BagMessage, BagReader
from .answers import Repertoire
from .session import Session
from .timeline import Timeline

# How soon it notices that it was paused, sent elsewhere or stopped.
_SLICE_S = 0.05


class Player:
    """Plays in the thread of its caller; the other attributes may be read by any.

    Attributes:
        sent: messages, `sent_bytes` their payloads.
    """

    def __init__(
        self, reader: BagReader, repertoire: Repertoire, session: Session, timeline: Timeline
    ) -> None:
        self.sent = self.sent_bytes = 0
        self._reader, self._session, self._timeline = reader, session, timeline
        self._topics = {
            topic.full_name(reader.prefix): (topic, _capture_ns(topic))
            for topic in repertoire.topics
        }
        # A subscriber that comes later gets their last message.
        self._latched = {name for name, (it, _) in self._topics.items() if it.qos == "latched"}

    def play(self, stopping: threading.Event) -> None:
        """From where the timeline stands to the last message, or until `stopping`.

        Raises:
            RecordingError, PlaybackError
        """
        while not self._is_over(stopping):
            self._session.epoch += 1

    def _is_over(self, stopping: threading.Event) -> bool:
        """Reads the recording once; False when the timeline has jumped meanwhile."""
        jumps, start_ns = self._timeline.place
        latched: dict[str, BagMessage] = {}
        for message in self._reader.messages():
            if stopping.is_set():
                return True
            if message.time_ns < start_ns:
                if message.topic in self._latched:
                    latched[message.topic] = message
                continue
            for earlier in latched.values():
                self._send(earlier)
            latched.clear()
            if not self._is_due(message, jumps, stopping):
                return stopping.is_set()
            self._send(message)
        return True

    def _is_due(self, message: BagMessage, jumps: int, stopping: threading.Event) -> bool:
        """Waits until it is; False when that is no longer to be waited for."""
        while self._timeline.place[0] == jumps and not stopping.is_set():
            self._timeline.go(jumps)
            left_s = self._timeline.left_s(message.time_ns)
            if left_s is not None and left_s <= 0:
                return True
            stopping.wait(_SLICE_S if left_s is None else min(left_s, _SLICE_S))
        return False

    def _send(self, message: BagMessage) -> None:
        if message.topic not in self._topics:
            return
        topic, capture_ns = self._topics[message.topic]
        if not self._session.is_wanted(topic):
            return
        _check(message, topic)
        self._session.send(topic, message.payload, capture_ns(message))
        self.sent += 1
        self.sent_bytes += len(message.payload)


def _capture_ns(topic: Topic) -> Callable[[BagMessage], int]:
    """The function that finds out when a message was captured, or else received."""
    if topic.type not in DEFINITIONS:
        return lambda message: message.time_ns
    read = stamp_reader(topic.type)

    def capture_ns(message: BagMessage) -> int:
        try:
            return read(message.payload)
        except ValueError:
            return message.time_ns  # a message that has none, as an empty TFMessage

    return capture_ns


def _check(message: BagMessage, topic: Topic) -> None:
    limit = max_data_bytes(LaneKind.of(topic.lane))
    if len(message.payload) > limit:
        raise RecordingError(
            f"a message of {message.topic} has {len(message.payload)} B, expected at most {limit}"
        )
    if not message.payload.startswith(CDR_ENCAPSULATION):
        raise RecordingError(f"a message of {message.topic} is not little-endian CDR")

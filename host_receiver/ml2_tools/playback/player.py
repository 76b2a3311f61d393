"""Sends the messages of a recording when they are due."""

import threading
from collections import Counter
from collections.abc import Callable

from ml2_receiver.errors import RecordingError
from ml2_receiver.recording.message_definitions import DEFINITIONS
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.stamps import stamp_reader
from ml2_receiver.wire.frame import CDR_ENCAPSULATION

from ..bags.bag_reader import BagMessage, BagReader
from .answers import Repertoire
from .session import PlaybackSession
from .timeline import Timeline

# The longest wait before the player notices a pause, a jump or a stop.
_SLICE_S = 0.05
_NO_TOPIC: tuple[None, Callable[[BagMessage], int]] = None, lambda _: 0


class Player:
    """Sends the messages of a recording in the thread that calls play().

    Attributes:
        sent: the number of sent messages; any thread may read it.
        sent_bytes: the total size of their payloads; any thread may read it.
        unsent: the number of messages by topic that were due and are not for the receiver.
    """

    def __init__(
        self,
        reader: BagReader,
        repertoire: Repertoire,
        session: PlaybackSession,
        timeline: Timeline,
    ) -> None:
        self.sent = self.sent_bytes = 0
        self.unsent = Counter[str]()
        self._reader, self._session, self._timeline = reader, session, timeline
        self._topics = {
            topic.full_name(reader.prefix): (topic, _capture_ns(topic))
            for topic in repertoire.topics
        }
        # After a jump, the last earlier message of these topics is sent first.
        self._latched = {name for name, (it, _) in self._topics.items() if it.qos == "latched"}

    def play(self, stopping: threading.Event) -> None:
        """Plays from the timeline's position to the last message, or until `stopping` is set.

        Raises:
            RecordingError: the recording is broken.
            PlaybackError: the connection to the receiver is lost.
        """
        while not self._play_once(stopping):
            self._session.epoch += 1

    def _play_once(self, stopping: threading.Event) -> bool:
        """Plays from the timeline's position; returns False if the timeline jumps meanwhile."""
        jumps, start_ns = self._timeline.position
        latched: dict[str, BagMessage] = {}
        last_ns = start_ns
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
            if not self._wait_until_due(message, jumps, stopping):
                return stopping.is_set()
            self._send(message)
            last_ns = message.time_ns
        self._timeline.hold(last_ns)
        return True

    def _wait_until_due(self, message: BagMessage, jumps: int, stopping: threading.Event) -> bool:
        """Waits until the message is due; returns False after a jump or a stop."""
        while self._timeline.position[0] == jumps and not stopping.is_set():
            self._timeline.start(jumps)
            left_s = self._timeline.left_s(message.time_ns)
            if left_s is not None and left_s <= 0:
                return True
            stopping.wait(_SLICE_S if left_s is None else min(left_s, _SLICE_S))
        return False

    def _send(self, message: BagMessage) -> None:
        topic, capture_ns = self._topics.get(message.topic, _NO_TOPIC)
        if topic is None or not self._session.is_wanted(topic):
            self.unsent[message.topic] += 1
            return
        _check(message, topic)
        self._session.send(topic, message.payload, capture_ns(message))
        self.sent += 1
        self.sent_bytes += len(message.payload)


def _capture_ns(topic: Topic) -> Callable[[BagMessage], int]:
    """Returns a function that returns a message's capture time, or without one its receive time."""
    if topic.type not in DEFINITIONS:
        return lambda message: message.time_ns
    read = stamp_reader(topic.type)

    def capture_ns(message: BagMessage) -> int:
        try:
            return read(message.payload)
        except ValueError:
            return message.time_ns  # a message without a stamp, such as an empty TFMessage

    return capture_ns


def _check(message: BagMessage, topic: Topic) -> None:
    limit = topic.lane.max_payload_bytes
    if len(message.payload) > limit:
        raise RecordingError(
            f"a message of {message.topic} has {len(message.payload)} B, expected at most {limit}"
        )
    if not message.payload.startswith(CDR_ENCAPSULATION):
        raise RecordingError(f"a message of {message.topic} is not little-endian CDR")

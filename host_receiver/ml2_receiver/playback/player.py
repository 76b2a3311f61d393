"""Sends the messages of a recording when they are due."""

import struct
import threading
import time

from ..configuration.table import StreamTable, Topic
from ..errors import RecordingError
from ..recording.bag_reader import BagMessage, BagReader
from ..topics.stamps import stamp_reader
from ..wire.frame import CDR_ENCAPSULATION, LaneKind, max_data_bytes
from .session import Session


class Player:
    """Plays in the thread of its caller; the other attributes may be read by any.

    Args:
        rate: 2 is twice as fast.

    Attributes:
        sent: messages, `sent_bytes` their payloads.
    """

    def __init__(
        self, reader: BagReader, table: StreamTable, session: Session, rate: float
    ) -> None:
        self.sent = self.sent_bytes = 0
        self._reader, self._session, self._rate = reader, session, rate
        self._topics = {
            topic.full_name(reader.prefix): (topic, stamp_reader(topic.type))
            for stream in table.streams.values()
            for topic in stream.topics
        }

    def play(self, stopping: threading.Event) -> None:
        """From the first message to the last, or until `stopping`.

        Raises:
            RecordingError, PlaybackError
        """
        first_ns: int | None = None
        began_s = time.monotonic()
        for message in self._reader.messages():
            first_ns = message.time_ns if first_ns is None else first_ns
            due_s = began_s + (message.time_ns - first_ns) / 1e9 / self._rate
            if stopping.wait(max(0.0, due_s - time.monotonic())):
                return
            self._send(message)

    def _send(self, message: BagMessage) -> None:
        if message.topic not in self._topics:
            return
        topic, stamp = self._topics[message.topic]
        if not self._session.is_wanted(topic):
            return
        _check(message, topic)
        try:
            capture_ns = stamp(message.payload)
        except (struct.error, ValueError, KeyError, TypeError):
            capture_ns = message.time_ns  # a message that has none, as an empty TFMessage
        self._session.send(topic, message.payload, capture_ns)
        self.sent += 1
        self.sent_bytes += len(message.payload)


def _check(message: BagMessage, topic: Topic) -> None:
    limit = max_data_bytes(LaneKind.of(topic.lane))
    if len(message.payload) > limit:
        raise RecordingError(
            f"a message of {message.topic} has {len(message.payload)} B, expected at most {limit}"
        )
    if not message.payload.startswith(CDR_ENCAPSULATION):
        raise RecordingError(f"a message of {message.topic} is not little-endian CDR")

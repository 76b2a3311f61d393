"""The interface of the receiver's outputs: ROS, Zenoh and recordings."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from ..errors import PublishError
from ..table.stream_table import Topic
from ..wire.messages import StreamAnswer, StreamStatus
from .report import Report

type Publish = Callable[[bytearray], None]


def refuse(payload: bytearray) -> None:
    """Publishes nothing: stands for a topic that could not be opened.

    Raises:
        PublishError: always.
    """
    raise PublishError("the topic could not be opened")


@dataclass(frozen=True)
class Applied:
    """The answer of a headset to the configuration.

    `topics` are the announced topics; `states` has the state of each stream since the answer;
    `device_id` tells headsets apart that have the same name.
    """

    headset: str
    session: str
    streams: Mapping[str, StreamAnswer]
    topics: Sequence[Topic]
    states: Mapping[str, StreamStatus] = field(default_factory=dict)
    device_id: str = ""


class Sink(Protocol):
    """An output for topics, payloads and events: ROS, Zenoh or a recording.

    Calls of these methods do not overlap; they may overlap with calls of the functions that open()
    returned. None of them may block.
    """

    def open(self, topic: Topic) -> Publish:
        """Returns a function that publishes one payload of the topic, which may be open already.

        The function is called by one thread at a time, must not keep the payload, and raises
        PublishError if it cannot publish it. It does nothing once the topic has ended.

        Raises:
            PublishError: the topic cannot be created; the message is logged.
        """

    def configured(self, applied: Applied) -> None:
        """Takes the headset's answer to the configuration; topics that it lacks end."""

    def event(self, text: str) -> None:
        """Takes a log line for the user."""

    def session_ended(self, report: Report) -> None:
        """Takes the final counts of a session that is over."""

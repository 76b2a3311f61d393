"""What the receiver needs of the place its topics go to."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from ..table.stream_table import Topic
from ..wire.messages import StreamAnswer, StreamStatus
from .report import Report

type Publish = Callable[[bytearray], None]


@dataclass(frozen=True)
class Applied:
    """The answer of a headset to the configuration; `topics` are the announced ones.

    `states` are how its streams stand since.
    """

    headset: str
    session: str
    streams: Mapping[str, StreamAnswer]
    topics: Sequence[Topic]
    states: Mapping[str, StreamStatus] = field(default_factory=dict)


class Sink(Protocol):
    """Takes topics, payloads and events: ROS, or a recording.

    All but the functions that open() returns are called by one thread at a time. None may block.
    """

    def open(self, topic: Topic) -> Publish:
        """A function that publishes one payload of the topic, which may be open already.

        Raises PublishError when the topic cannot be made, which is told to the user.
        The function is called by one thread at a time, must not keep the payload, and raises
        PublishError when it cannot take it. Once the topic has ended it does nothing.
        """

    def configured(self, applied: Applied) -> None:
        """The headset has answered the configuration; topics that are not `applied`'s end."""

    def event(self, text: str) -> None:
        """Something a user wants to read happened."""

    def session_ended(self, report: Report) -> None:
        """A session is over and its counts are final."""

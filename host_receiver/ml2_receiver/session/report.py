"""A snapshot of a session, for users and diagnostics."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

from ..table.stream_table import Topic
from ..wire.kinds import Kind
from ..wire.messages import (
    ChannelStatus,
    ClockStatus,
    Condition,
    StreamAnswer,
    StreamStatus,
    Thermal,
)
from ..wire.opening_bodies import CallStatus
from .books import SubscriptionReport
from .link_tests import LinkTestResult
from .statistics import TopicStatistics


class State(Enum):
    """The state of a session; it is ENDED after a BYE and LOST without one."""

    CONNECTED = "connected"
    ENDED = "ended"
    LOST = "lost"


@dataclass(frozen=True)
class TopicReport:
    """One topic; `statistics` keeps counting, `device` is from the last STATUS.

    `is_running` is True if the headset is to send the topic at present.
    """

    topic: Topic
    statistics: TopicStatistics
    device: ChannelStatus | None
    is_running: bool = True


@dataclass(frozen=True)
class CallsReport:
    """A client or a service of the app, and how often each kind of its frames came or went.

    `device` is from the last STATUS.
    """

    id: int
    kind: str
    name: str
    type: str
    counts: Counter[Kind]
    device: CallStatus | None


@dataclass(frozen=True)
class OpeningsReport:
    """The openings of the app; `late` counts frames for openings that had ended."""

    late: int = 0
    subscriptions: Sequence[SubscriptionReport] = ()
    calls: Sequence[CallsReport] = ()


@dataclass(frozen=True)
class Report:
    """A snapshot of one session.

    Attributes:
        clock: from the last STATUS; None before the first one.
        is_final: True after the last STATUS.
        software: from HELLO, as are `capabilities` (the headset's streams) and `permissions`.
        answers: the headset's last answer for each stream.
        link_test: the last link test; None before the first one.
        thermal: from the last STATUS; None if the headset does not report it.
        streams: the state of each stream.
        conditions: how well the headset perceives what, from the last STATUS.
        openings: what the app has open, or had when the session ended.
    """

    state: State
    headset: str
    device_id: str
    clock: ClockStatus | None
    skipped_frames: int
    is_final: bool
    topics: Sequence[TopicReport]
    software: str = ""
    capabilities: Sequence[str] = ()
    permissions: Mapping[str, bool] = field(default_factory=dict)
    answers: Mapping[str, StreamAnswer] = field(default_factory=dict)
    link_test: LinkTestResult | None = None
    thermal: Thermal | None = None
    streams: Mapping[str, StreamStatus] = field(default_factory=dict)
    conditions: Mapping[str, Condition] = field(default_factory=dict)
    openings: OpeningsReport = field(default_factory=OpeningsReport)

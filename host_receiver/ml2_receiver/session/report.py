"""How a session stands, for people and diagnostics."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum

from ..table.stream_table import Topic
from ..wire.messages import ChannelStatus, ClockStatus, StreamAnswer, StreamStatus, Thermal
from .statistics import TopicStatistics
from .throughput import Throughput


class State(Enum):
    """ENDED had its BYE, LOST had not."""

    CONNECTED = "connected"
    ENDED = "ended"
    LOST = "lost"


@dataclass(frozen=True)
class TopicReport:
    """One topic; `statistics` goes on counting, `device` is as of the last STATUS.

    `is_running`: the headset is to run its stream at present.
    """

    topic: Topic
    statistics: TopicStatistics
    device: ChannelStatus | None
    is_running: bool = True


@dataclass(frozen=True)
class Report:
    """One session. `clock` is None before the first STATUS; `is_final` after the last one.

    `software`, `capabilities` (streams it has) and `permissions` are the headset's own words;
    `answers` are its last ones, by stream, and `streams` how they stand since; `link` is the last
    link test, None when there was none; `thermal` is None where it does not say.
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
    link: Throughput | None = None
    thermal: Thermal | None = None
    streams: Mapping[str, StreamStatus] = field(default_factory=dict)

"""Judges whether each stream delivers, by what the headset says of it and by what arrives."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from ..session.report import Report, State, TopicReport
from ..session.statistics import TopicStatistics
from ..session.stream_state import Judgement, judged
from ..wire.messages import StreamStatus

_SHORTEST_S = 2.0
# The first sample may take so much longer than later ones, as on the headset.
_OPENING_S = 6.0
_RUNNING, _PAUSED = Judgement("running"), Judgement("paused")
_NOTHING_YET = Judgement("waiting", "no message has come yet")
_WITHOUT_SESSION = {
    State.ENDED: Judgement("paused", "the session has ended"),
    State.LOST: Judgement("silent", "the connection is lost"),
}
_UNDER_WAY = Judgement("silent", "the headset produces messages, and none arrives")
# The state of a stream is the first of these that one of its topics has.
_DECISIVE = ("silent", "waiting", "running", "paused")
_STATE, _PERMISSION = "state.", "missing."


@dataclass
class _Past:
    """The arrival of a topic's messages, as of the previous call.

    Attributes:
        began_s: the time from which on messages are expected.
        arrived_s: the time of the last message since then; None before the first.
        caught_up_s: the last time at which nothing was under way from the headset.
    """

    statistics: TopicStatistics
    began_s: float
    caught_up_s: float
    arrived_s: float | None = None
    received: int = 0
    produced: int = 0


@dataclass(frozen=True)
class Judgements:
    """The judgements of one moment: of each topic of the report, and of each enabled stream."""

    topics: list[Judgement]
    streams: dict[str, Judgement]


class Judge:
    """Judges the streams of a session again and again. Not thread-safe."""

    def __init__(self) -> None:
        self._past: dict[str, _Past] = {}

    def judge(self, report: Report, now_s: float) -> Judgements:
        """Judges by the time since the last message of each topic, as seen by earlier calls."""
        topics = [self._topic(topic, report, now_s) for topic in report.topics]
        by_stream: dict[str, list[Judgement]] = {}
        for it, judgement in zip(report.topics, topics, strict=True):
            by_stream.setdefault(it.topic.stream, []).append(judgement)
        streams = {
            id: _stream(status, by_stream.get(id, ()), report.state)
            for id, status in report.streams.items()
        }
        return Judgements(topics, streams)

    def _topic(self, topic: TopicReport, report: Report, now_s: float) -> Judgement:
        past = self._note(topic, now_s)
        status = report.streams.get(topic.topic.stream)
        told = _WITHOUT_SESSION.get(report.state, _RUNNING if topic.is_running else _PAUSED)
        if told == _RUNNING and status is not None and status.state != "running":
            told = judged(status)
        if told != _RUNNING:
            past.began_s, past.caught_up_s, past.arrived_s = now_s, now_s, None
            return told
        return _heard(topic, past, expected_hz(topic, report), now_s)

    def _note(self, topic: TopicReport, now_s: float) -> _Past:
        """Compares the counters of a topic with those of the previous call."""
        name, statistics = topic.topic.name, topic.statistics
        past = self._past.get(name)
        if past is None or past.statistics is not statistics:
            past = self._past[name] = _Past(statistics, now_s, now_s)
        produced = topic.device.produced if topic.device else 0
        dropped = sum(topic.device.dropped.values()) if topic.device else 0
        has_arrived = statistics.received > past.received
        if has_arrived:
            past.arrived_s = now_s
        # STATUS counts late, so what it counts newly may have arrived long ago
        if has_arrived or produced - dropped <= statistics.received or produced <= past.produced:
            past.caught_up_s, past.produced = now_s, produced
        past.received = statistics.received
        return past


def _stream(status: StreamStatus, topics: Collection[Judgement], state: State) -> Judgement:
    if status.state != "running":
        return judged(status)
    default = _WITHOUT_SESSION.get(state, _RUNNING)
    return min(topics, key=lambda it: _DECISIVE.index(it.state), default=default)


def _heard(topic: TopicReport, past: _Past, rate_hz: float | None, now_s: float) -> Judgement:
    """Judges a topic whose stream is to run, and runs as far as the headset knows."""
    if now_s - past.caught_up_s > _SHORTEST_S:
        return _UNDER_WAY
    longest_s: float | None = topic.topic.pace.longest_pause_s
    if longest_s is None:
        return _RUNNING
    expected = f"a message every {longest_s} s"
    if rate_hz is not None:
        longest_s, expected = max(_SHORTEST_S, 2 / rate_hz), f"{rate_hz:g} Hz"
    silence_s = now_s - (past.began_s if past.arrived_s is None else past.arrived_s)
    if silence_s > longest_s + (_OPENING_S if past.arrived_s is None else 0):
        return Judgement("silent", f"nothing has come for {silence_s:.0f} s, expected {expected}")
    return _RUNNING if topic.statistics.received else _NOTHING_YET


def expected_hz(topic: TopicReport, report: Report) -> float | None:
    """Returns the lowered rate of a camera, else the promised one, else the nominal one if any.

    None means that the topic comes as delivered.
    """
    if topic.topic.pace.longest_pause_s is None:
        return None
    status = report.streams.get(topic.topic.stream)
    if status is not None and status.rate_hz is not None:
        return float(status.rate_hz)
    answer = report.answers.get(topic.topic.stream)
    promised = (answer.values or {}).get("update_rate") if answer else None
    if isinstance(promised, int | float) and promised > 0:
        return float(promised)
    return topic.topic.pace.rate_hz


def judgement_values(judgements: Mapping[str, Judgement]) -> dict[str, str]:
    """Returns the values of the row "session" from which read_judgements() reads."""
    values = {f"{_STATE}{id}": it.text for id, it in judgements.items()}
    return values | {
        f"{_PERMISSION}{id}": it.permission
        for id, it in judgements.items()
        if it.permission is not None
    }


def read_judgements(session: Mapping[str, str]) -> dict[str, Judgement]:
    """Reads the judgement of each enabled stream from the row "session" of /diagnostics."""
    return {
        (id := key.removeprefix(_STATE)): Judgement.parse(text, session.get(f"{_PERMISSION}{id}"))
        for key, text in session.items()
        if key.startswith(_STATE)
    }

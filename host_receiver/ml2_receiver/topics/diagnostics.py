"""Turns reports into the rows of /diagnostics."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ..session.books import SubscriptionReport
from ..session.link_tests import LinkTestResult
from ..session.report import CallsReport, Report, State, TopicReport
from ..session.statistics import SHARES, TopicStatistics
from ..session.stream_state import Judgement, in_words
from ..wire.kinds import Kind
from ..wire.messages import ChannelStatus, ClockStatus, Condition, StreamAnswer, StreamStatus
from .adaptation import ADAPTATION, adaptation_message, adaptation_values
from .judgement import Judge, expected_hz, judgement_values

# A head that turns by 100 degrees/s is seen half a degree off when a stamp is wrong by this much.
_UNCERTAIN_NS = 5_000_000
ALL_ARRIVED, LOST = "all that was produced arrived", "lost messages"
CALLS = ("client ", "service ")  # and the name: the rows of those of the app
_OF_CALLS = (Kind.REQUEST, Kind.RESPONSE, Kind.FAILURE)
SUBSCRIPTION = "subscription "  # and the topic: the row of a subscription of the app
CONDITION = "headset "  # and what it perceives
# From this state on, Android slows the headset down noticeably.
_HOT = {"severe", "critical", "emergency", "shutdown"}


class Level(IntEnum):
    """The levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True)
class Row:
    """A DiagnosticStatus, without the name of the node."""

    name: str
    level: Level
    message: str
    values: dict[str, str]


@dataclass
class _Past:
    """The counters of a topic at the previous call."""

    statistics: TopicStatistics
    time_s: float
    received: int = 0
    received_bytes: int = 0


class Diagnostics:
    """Makes rows with rates over the time since the previous call of rows(). Not thread-safe.

    Args:
        prefix: the prefix of the relative topics.
    """

    def __init__(self, prefix: str) -> None:
        self._prefix = prefix
        self._judge = Judge()
        self._past: dict[str, _Past] = {}

    def rows(self, report: Report | None, now_s: float) -> list[Row]:
        """Returns the rows of the session, its clock, its last link test, adaptation and topics.

        Rows that do not apply are left out, such as `adaptation` and those of what the headset
        perceives without a connection.
        """
        if report is None:
            return [Row("session", Level.OK, "no headset yet", {"state": "waiting"})]
        clock = [] if report.clock is None else [_clock(report.clock)]
        link = [] if report.link_test is None else [_link(report.link_test)]
        present = [_adaptation(report.streams)] if report.state is State.CONNECTED else []
        if present:
            present += [_condition(name, it) for name, it in sorted(report.conditions.items())]
        judgements = self._judge.judge(report, now_s)
        topics = [
            self._topic(topic, judgement, report, now_s)
            for topic, judgement in zip(report.topics, judgements.topics, strict=True)
        ]
        openings = [_subscription(it) for it in report.openings.subscriptions]
        openings += [_calls(it) for it in report.openings.calls]
        head = [_session(report, judgements.streams), *clock, *link, *present]
        return [*head, *topics, *openings]

    def _topic(self, topic: TopicReport, judgement: Judgement, report: Report, now_s: float) -> Row:
        statistics = topic.statistics
        name = topic.topic.full_name(self._prefix)
        past = self._past.get(name)
        if past is None or past.statistics is not statistics:
            past = self._past[name] = _Past(statistics, now_s)
        elapsed_s = now_s - past.time_s
        received, received_bytes = statistics.received, statistics.received_bytes
        values = {
            "stream": topic.topic.stream,
            "type": topic.topic.type,
            "rate_hz": _per_second(received - past.received, elapsed_s),
            "mbit_per_s": _per_second((received_bytes - past.received_bytes) * 8e-6, elapsed_s),
            "received": str(received),
            "gaps": str(_gaps(topic, report)),
            "unpublished": str(statistics.unpublished),
        }
        if (needed := _needed(topic, report)) is not None:
            values["needs"] = needed
        elif (rate_hz := expected_hz(topic, report)) is not None:
            values["expected_hz"] = f"{rate_hz:g}"
        values |= _reported(topic, report) | _latency(statistics)
        values |= _window(statistics.times_ns(past.received, received))
        past.time_s, past.received, past.received_bytes = now_s, received, received_bytes
        return Row(name, *_in_words(topic, judgement, _gaps(topic, report)), values)


def _needed(topic: TopicReport, report: Report) -> str | None:
    """Returns the value without which the headset does not send a topic, unless it is set."""
    condition, answer = topic.topic.when, report.answers.get(topic.topic.stream)
    values = (answer.values if answer else None) or {}
    if condition is None or condition.key not in values or condition.holds(values):
        return None
    is_word = isinstance(condition.value, bool)
    return f"{condition.key}={str(condition.value).lower() if is_word else condition.value}"


def _in_words(topic: TopicReport, judgement: Judgement, gaps: int) -> tuple[Level, str]:
    dropped = sum(topic.device.dropped.values()) if topic.device else 0
    if judgement.is_wrong:
        is_error = judgement.state in ("silent", "failed")
        words = in_words(topic.topic.stream, judgement)
        return Level.ERROR if is_error else Level.WARN, words
    if dropped or gaps or topic.statistics.unpublished:
        return Level.WARN, f"{LOST}: {max(dropped, gaps)}"
    is_running = judgement.state == "running"
    return Level.OK, ALL_ARRIVED if is_running else judgement.text


def _gaps(topic: TopicReport, report: Report) -> int:
    """Returns the number of messages that never arrived.

    Losses after the last arrival show only at the end.
    """
    if topic.device is not None and _is_over(report):
        return topic.device.produced - topic.statistics.received
    return topic.statistics.gaps


def _reported(topic: TopicReport, report: Report) -> dict[str, str]:
    """Returns what the device has counted; nothing before its first STATUS."""
    device = topic.device
    if device is None:
        return {}
    dropped = _dropped(topic, device, report)
    return {
        "produced": str(device.produced),
        "sent": str(device.sent),
        **{f"dropped.{reason}": str(count) for reason, count in dropped.items()},
    }


def _dropped(topic: TopicReport, device: ChannelStatus, report: Report) -> Mapping[str, int]:
    """Returns drops by reason; after the end, messages lost on the way are `link_down`."""
    missing = device.sent - topic.statistics.received
    if missing == 0 or not _is_over(report):
        return device.dropped
    return {**device.dropped, "link_down": device.dropped.get("link_down", 0) + missing}


def _is_over(report: Report) -> bool:
    return report.is_final and report.state is not State.CONNECTED


def _answer(answer: StreamAnswer) -> str:
    return answer.result if answer.reason is None else f"{answer.result}: {answer.reason}"


def _session(report: Report, judgements: Mapping[str, Judgement]) -> Row:
    values = {
        "state": report.state.value,
        "headset": report.headset,
        "device_id": report.device_id,
        "skipped_frames": str(report.skipped_frames),
        "late_frames": str(report.openings.late),
        "final": str(report.is_final).lower(),
        "software": report.software,
        "capabilities": " ".join(report.capabilities),
    }
    values |= {
        f"permission.{it}": str(granted).lower() for it, granted in report.permissions.items()
    }
    values |= {f"stream.{id}": _answer(answer) for id, answer in report.answers.items()}
    values |= judgement_values(judgements)
    message = f"{report.headset}: {report.state.value}"
    if report.thermal is not None:
        values["thermal"] = report.thermal
    if report.state is State.LOST:
        return Row("session", Level.ERROR, message, values)
    warnings = [f"hot: {report.thermal}"] if report.thermal in _HOT else []
    if report.state is State.CONNECTED:
        warnings += [f"{id} {in_words(id, it)}" for id, it in judgements.items() if it.is_wrong]
    level = Level.WARN if warnings else Level.OK
    return Row("session", level, "; ".join([message, *warnings]), values)


def security_row(paired: Mapping[str, str] | None) -> Row:
    """Makes the row about who may connect, as Access.paired() has them."""
    if paired is None:
        message = "insecure: no encryption, and everybody may connect"
        return Row("security", Level.WARN, message, {"tls": "false"})
    values = {"tls": "true"} | {f"paired.{id}": name for id, name in paired.items()}
    return Row("security", Level.OK, f"TLS 1.3, {len(paired)} paired", values)


def _clock(clock: ClockStatus) -> Row:
    values = {
        "state": clock.state,
        "offset_ns": str(clock.offset_ns),
        "uncertainty_ns": str(clock.uncertainty_ns),
        "round_trip_ns": str(clock.round_trip_ns),
    }
    optional = {"skew_ppm": clock.skew_ppm, "steps": clock.steps, "epoch": clock.epoch}
    values |= {key: str(value) for key, value in optional.items() if value is not None}
    values |= {f"bases.{stream}": base for stream, base in (clock.bases or {}).items()}
    is_vague = clock.uncertainty_ns > _UNCERTAIN_NS
    level = Level.WARN if is_vague or clock.state == "holdover" else Level.OK
    message = f"{clock.state}, stamps within {clock.uncertainty_ns / 1e6:.3f} ms of the capture"
    return Row("clock", level, message, values)


def _link(test: LinkTestResult) -> Row:
    values = {"state": test.state, "tests": str(test.number)}
    if test.state != "measured":
        level = Level.OK if test.state == "running" else Level.WARN
        return Row("link", level, f"link test: {test.state}", values)
    values |= {
        "filler_bytes": str(test.filler_bytes),
        "duration_s": f"{test.duration_s:.3f}",
        "free_mbit_per_s": f"{test.free_mbit_per_s:.2f}",
        "streams_mbit_per_s": f"{test.streams_mbit_per_s:.2f}",
    }
    free, streams = test.free_mbit_per_s, test.streams_mbit_per_s
    message = f"{free:.0f} Mbit/s were free besides {streams:.0f} of the streams"
    return Row("link", Level.OK, message, values)


def _adaptation(streams: Mapping[str, StreamStatus]) -> Row:
    values = adaptation_values(streams)
    level = Level.WARN if values else Level.OK
    return Row(ADAPTATION, level, adaptation_message(values), values)


def _condition(name: str, condition: Condition) -> Row:
    level = Level.OK if condition.level == "ok" else Level.WARN
    return Row(f"{CONDITION}{name}", level, condition.message, dict(condition.values))


def _subscription(report: SubscriptionReport) -> Row:
    """Makes the row of a subscription of the app; a newer message may supersede one by design."""
    book, device = report.book, report.device
    counts = {"produced": book.produced, "sent": book.sent, "waiting": book.waiting}
    counts |= {f"dropped.{reason}": count for reason, count in book.dropped.items()}
    counts |= {"missed": book.missed}
    counts |= {f"app.{what}": count for what, count in vars(device).items()} if device else {}
    values = {"id": str(report.id), "message_type": report.type}
    values |= {what: str(count) for what, count in counts.items()}
    lost = book.missed + book.dropped.total() - book.dropped["superseded"] - book.dropped["closed"]
    level, message = (Level.WARN, f"{LOST}: {lost}") if lost else (Level.OK, ALL_ARRIVED)
    return Row(f"{SUBSCRIPTION}{report.name}", level, message, values)


def _calls(report: CallsReport) -> Row:
    """Makes the row of a client or service of the app; who has called is told of a failure."""
    values = {"id": str(report.id), "service_type": report.type}
    values |= {f"{it.name.lower()}s": str(report.counts[it]) for it in _OF_CALLS}
    if (device := report.device) is not None:
        counts = {"requests": device.requests, "responses": device.responses}
        counts |= {f"failures.{code}": count for code, count in device.failures.items()}
        values |= {f"app.{what}": str(count) for what, count in counts.items()}
    return Row(f"{report.kind} {report.name}", Level.OK, "open", values)


def _latency(statistics: TopicStatistics) -> dict[str, str]:
    latency = statistics.latency()
    return {f"latency_{what}": f"{ms:.3f}" for what, ms in vars(latency).items()} if latency else {}


def _window(times_ns: NDArray[np.int64]) -> dict[str, str]:
    """Returns what `ml2-receiver latency` needs about the messages since the last call."""
    values = {"window.messages": str(len(times_ns))}
    if not len(times_ns):
        return values
    values["window.first_capture_ns"] = str(times_ns[0, 0])
    values["window.last_capture_ns"] = str(times_ns[-1, 0])
    if times_ns[:, 1].all():  # A device that does not know ROS time yet sends 0
        shares_ms = np.diff(times_ns).mean(axis=0) / 1e6
        values |= {
            f"window.{share}_ms": f"{ms:.3f}" for share, ms in zip(SHARES, shares_ms, strict=True)
        }
    return values


def _per_second(amount: float, elapsed_s: float) -> str:
    return f"{amount / elapsed_s:.2f}" if elapsed_s > 0 else "0.00"

"""Checks rate, gaps, jitter, order of stamps and latency of one topic."""

from collections.abc import Iterator

import numpy as np

from .check import Check, Verdict, verdict_on_share
from .survey import READ, TRANSFORMS, Stamps, TopicRecord

IMU, IMAGES = (
    "sensor_msgs/msg/Imu",
    (
        "sensor_msgs/msg/Image",
        "sensor_msgs/msg/CompressedImage",
        "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
        "foxglove_msgs/msg/CompressedVideo",
    ),
)
PERIODIC = (IMU, *IMAGES)
_MS = 1e6
# An interval of more than 1.5 periods is nearer to two periods than to one.
_GAP_PERIODS = 1.5
_MOST_MISSING = 0.01
_RATE_TOLERANCE = 0.05
# The usual VIO packages preintegrate an IMU at 100 to 200 Hz and more.
_LEAST_IMU_HZ = 100.0
# Shares of a period. A tenth is 3 ms for a camera at 30 Hz, in which a head that turns by 150 deg/s
# turns by half a degree.
_JITTER_HINT, _JITTER_WRONG = 0.1, 0.25
_HISTOGRAM_BINS = 21
# People notice 0.1 s of latency. 10 s mean a replay or a wrong clock.
_LATENCY_HINT_MS, _LATENCY_WRONG_MS = 100.0, 10_000.0


def timing(name: str, topic: TopicRecord) -> Iterator[Check]:
    """Runs the checks that need only the stamps of one topic."""
    yield _messages(name, topic)
    if not topic.stamps:
        return
    if topic.type != TRANSFORMS:  # transforms may come in any order
        yield _order(name, topic.stamps_ns)
    intervals_ns = np.diff(topic.stamps_ns)
    intervals_ns = intervals_ns[intervals_ns > 0]
    if topic.type in PERIODIC and len(intervals_ns) >= 2:
        usual_ns = intervals_ns[intervals_ns < _GAP_PERIODS * np.median(intervals_ns)]
        period_ns = float(usual_ns.mean())
        yield _rate(name, topic, 1e9 / period_ns)
        yield _gaps(name, intervals_ns, 1e9 / topic.promised_hz if topic.promised_hz else period_ns)
        yield _jitter(name, usual_ns, period_ns)
    yield _latency(name, (topic.received_ns - topic.stamps_ns) / _MS)


def _messages(name: str, topic: TopicRecord) -> Check:
    figures = {"messages": topic.messages, "broken": topic.broken}
    if topic.broken:
        found = f"{topic.broken} of {topic.messages} messages are broken: {topic.fault}"
        return Check(name, "messages", "wrong", found, figures)
    if not topic.messages:
        return Check(name, "messages", "hint", "the topic has no messages", figures)
    if topic.type not in READ:
        type = topic.type or "no type"
        found = f"{topic.messages} messages of {type}, which is not checked"
        return Check(name, "messages", "hint", found, figures)
    return Check(name, "messages", "ok", f"{topic.messages} messages", figures)


def _order(name: str, stamps_ns: Stamps) -> Check:
    steps_ns = np.diff(stamps_ns)
    repeated, back = int((steps_ns == 0).sum()), int((steps_ns < 0).sum())
    worst_ms = float(-steps_ns.min(initial=0)) / _MS
    figures = {"repeated": repeated, "steps_back": back, "largest_step_back_ms": worst_ms}
    if not repeated and not back:
        return Check(name, "stamps", "ok", "stamps rise", figures)
    found = f"{repeated} stamps repeat, {back} go back, by at most {worst_ms:.3g} ms"
    return Check(name, "stamps", "wrong", found, figures)


def _rate(name: str, topic: TopicRecord, rate_hz: float) -> Check:
    promised_hz = topic.promised_hz
    found, figures = f"{rate_hz:.2f} Hz", {"rate_hz": rate_hz}
    if promised_hz is not None:
        figures["promised_hz"] = promised_hz
        is_kept = abs(rate_hz - promised_hz) <= _RATE_TOLERANCE * promised_hz
        found += f", promised {promised_hz:g} Hz"
        return Check(name, "rate", "ok" if is_kept else "wrong", found, figures)
    if topic.type == IMU and rate_hz < _LEAST_IMU_HZ:
        found += f", less than the {_LEAST_IMU_HZ:g} Hz that VIO needs"
        return Check(name, "rate", "hint", found, figures)
    return Check(name, "rate", "ok", found, figures)


def _gaps(name: str, intervals_ns: Stamps, period_ns: float) -> Check:
    wide = intervals_ns[intervals_ns > _GAP_PERIODS * period_ns]
    missing = int(np.rint(wide / period_ns - 1).sum())
    expected = missing + len(intervals_ns) + 1
    longest_ms = float(intervals_ns.max()) / _MS
    figures = {"gaps": len(wide), "missing": missing, "longest_interval_ms": longest_ms}
    if not missing:
        return Check(name, "gaps", "ok", f"no gap, at most {longest_ms:.1f} ms apart", figures)
    found = f"{missing} of {expected} missing in {len(wide)} gaps, the longest {longest_ms:.1f} ms"
    verdict = verdict_on_share(missing, expected, _MOST_MISSING)
    return Check(name, "gaps", verdict, found, figures)


def _jitter(name: str, intervals_ns: Stamps, period_ns: float) -> Check:
    """Checks the jitter of stamps; `intervals_ns` must not contain gaps."""
    off_ms = (intervals_ns - period_ns) / _MS
    p99_ms = float(np.percentile(np.abs(off_ms), 99))
    limit_ms = (_GAP_PERIODS - 1) * period_ns / _MS
    counts, edges_ms = np.histogram(
        off_ms.clip(-limit_ms, limit_ms), _HISTOGRAM_BINS, (-limit_ms, limit_ms)
    )
    share = p99_ms * _MS / period_ns
    verdict: Verdict = "hint" if share <= _JITTER_WRONG else "wrong"
    verdict = "ok" if share <= _JITTER_HINT else verdict
    found = f"99 % of intervals are within {p99_ms:.2g} ms of {period_ns / _MS:.2f} ms"
    figures = {
        "period_ms": period_ns / _MS,
        "p99_ms": p99_ms,
        "std_ms": float(off_ms.std()),
        "histogram_counts": counts.tolist(),
        "histogram_edges_ms": edges_ms.tolist(),
    }
    return Check(name, "jitter", verdict, found, figures)


def _latency(name: str, latencies_ms: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Check:
    """Checks the latency of the recording: the time of recording minus the stamp."""
    p50_ms, p99_ms = (float(it) for it in np.percentile(latencies_ms, (50, 99)))
    least_ms, most_ms = float(latencies_ms.min()), float(latencies_ms.max())
    figures = {"p50_ms": p50_ms, "p99_ms": p99_ms, "min_ms": least_ms, "max_ms": most_ms}
    if least_ms < 0:
        found = f"recorded up to {-least_ms:.3g} ms before the capture: clocks disagree"
        return Check(name, "latency", "wrong", found, figures)
    verdict: Verdict = "ok" if p99_ms <= _LATENCY_HINT_MS else "hint"
    found = f"p50 {p50_ms:.1f} ms, p99 {p99_ms:.1f} ms"
    if least_ms > _LATENCY_WRONG_MS:
        found = f"over {_LATENCY_WRONG_MS / 1000:.0f} s: a replay of old data, or a wrong clock"
    return Check(name, "latency", verdict, found, figures)

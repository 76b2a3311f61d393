"""Finds lost messages, and the topic with the worst latency, in the rows of /diagnostics."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ..monitoring.topic_table import number_of
from .findings import Finding, Level

# Any loss is reported: a single message matters if an IMU is integrated. Odometry and calibration
# fail if this share of a topic is lost.
_WRONG_SHARE = 0.01
# Three images at 30 Hz. People see such a delay, and controllers must predict.
_LATE_MS = 100.0
# No sensor takes as long, so a queue is full somewhere.
_WRONG_MS = 1000.0
_MOST_TOPICS, _MOST_REASONS = 5, 4
_DROPPED = "dropped."

type Rows = Mapping[str, Mapping[str, str]]


@dataclass(frozen=True)
class _Topic:
    """Counts of the messages of one topic, and their latency; None if it is not reported."""

    name: str
    received: int
    lost: int
    unpublished: int
    dropped: Counter[str]
    p99_ms: float | None

    @property
    def missing(self) -> int:
        return self.lost + self.unpublished

    @property
    def missing_share(self) -> float:
        # `received` includes messages that were not published.
        return self.missing / max(self.received + self.lost, 1)


def delivery(rows: Rows) -> Iterator[Finding]:
    """Yields a finding for losses, and one for latency; neither before the first message."""
    topics = [_topic(name, values) for name, values in rows.items() if "stream" in values]
    if any(it.received or it.missing for it in topics):
        yield _losses(topics)
    late = [(it.p99_ms, it.name) for it in topics if it.p99_ms is not None]
    if late:
        yield _latency(*max(late))


def _losses(topics: list[_Topic]) -> Finding:
    missing = sorted((it for it in topics if it.missing), key=lambda it: -it.missing)
    received = sum(it.received for it in topics)
    numbers = {"lost": float(sum(it.missing for it in topics)), "received": float(received)}
    if not missing:
        return Finding("losses", "ok", f"none of {received} messages", numbers=numbers)
    found = ", ".join(
        f"{it.missing} of {it.name} ({it.missing_share:.1%})" for it in missing[:_MOST_TOPICS]
    )
    if len(missing) > _MOST_TOPICS:
        found += f", and of {len(missing) - _MOST_TOPICS} more topics"
    is_wrong = any(it.missing_share >= _WRONG_SHARE for it in missing)
    level: Level = "wrong" if is_wrong else "hint"
    return Finding("losses", level, f"lost {found}", _mending(missing), numbers)


def _mending(topics: list[_Topic]) -> str:
    reasons = sum((it.dropped for it in topics), Counter[str]())
    fixes = []
    if any(it.unpublished for it in topics):
        fixes.append("the receiver's log says why it could not publish some")
    if reasons:
        words = ", ".join(f"{n} {reason}" for reason, n in reasons.most_common(_MOST_REASONS))
        fixes.append(f"the headset dropped {words}: the link may be too slow (row link, above)")
    fixes.append("`ml2-receiver topics` shows whether it goes on; docs/diagnostics.md has reasons")
    return "; ".join(fixes)


def _latency(p99_ms: float, topic: str) -> Finding:
    found = f"{topic} is the latest: 99 % of its messages come within {p99_ms:.1f} ms"
    numbers = {"p99_ms": p99_ms}
    if p99_ms <= _LATE_MS:
        return Finding("latency", "ok", found, numbers=numbers)
    fix = "`ml2-receiver latency` shows where the time goes; lower formats or rates of images"
    level: Level = "wrong" if p99_ms > _WRONG_MS else "hint"
    return Finding("latency", level, found, fix, numbers)


def _topic(name: str, values: Mapping[str, str]) -> _Topic:
    dropped = Counter(
        {
            key.removeprefix(_DROPPED): count
            for key, text in values.items()
            if key.startswith(_DROPPED) and (count := _count(text))
        }
    )
    return _Topic(
        name,
        _count(values.get("received", "")),
        max(_count(values.get("gaps", "")), dropped.total()),
        _count(values.get("unpublished", "")),
        dropped,
        number_of(values.get("latency_p99_ms")),
    )


def _count(text: str) -> int:
    """Returns a count; 0 for what another node may have put there."""
    return int(max(number_of(text) or 0, 0))

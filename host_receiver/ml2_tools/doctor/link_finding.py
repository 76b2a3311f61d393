"""The finding of `ml2-receiver doctor` about the link: does it carry what the streams need?"""

from collections.abc import Mapping

from ml2_receiver.configuration.config import Config
from ml2_receiver.configuration.forecast import images_mbit_per_s
from ml2_receiver.configuration.link_fit import advice
from ml2_receiver.topics.adaptation import ADAPTATION, lowered_streams

from ..monitoring.topic_table import number_of
from .findings import Finding

_MOST = 1e15  # nothing that is measured here is more
_CHECK = "link to headset"
_BETTER_LINK = "use Wi-Fi of 5 or 6 GHz near its access point, or a cable"
_BETTER_LINK_OR_LESS = (
    f"{_BETTER_LINK}; or ask for less: compressed formats, a lower quality or update_rate, fewer"
    " streams"
)
_NOT_THE_LINK = (
    "the link carries enough now: look whether this machine is busy, and look again, as the link"
    " may be worse at times"
)

type Row = Mapping[str, str]
type Rows = Mapping[str, Row]


def link_finding(rows: Rows | str, test: Row | str, config: Config | None = None) -> Finding:
    """Returns the finding about the link, from /diagnostics of a running receiver.

    Args:
        rows: the rows of /diagnostics, or the reason why there are none.
        test: the row of a link test, or the reason why there was none. The test runs beside the
            streams and shares the link with them, so the link carries the sum of both.
        config: the configuration in force; None if it is not known.
    """
    again = "look again while a headset streams"
    if isinstance(rows, str):
        return Finding(_CHECK, "hint", f"not measured: {rows}", again)
    state = rows.get("session", {}).get("state")
    if state != "connected":
        return Finding(_CHECK, "hint", f"not measured: the session is {state}", again)
    needs = _needs(rows, config)
    numbers = _arriving(rows) | {"needed_mbit_per_s": round(sum(needs.values()), 2)} | _tested(test)
    return _judged(numbers, needs, config, _lowered(rows), _why(test))


def _judged(
    numbers: Mapping[str, float],
    needs: Mapping[str, float],
    config: Config | None,
    lowered: str,
    why_not_tried: str,
) -> Finding:
    slowest = f"p99 of the slowest topic {numbers['slowest_p99_ms']:.1f} ms"
    found = [f"{numbers['arriving_mbit_per_s']:.1f} Mbit/s arrive, {slowest}"]
    if "free_mbit_per_s" in numbers:
        free, streams = numbers["free_mbit_per_s"], numbers["streams_mbit_per_s"]
        needed = sum(needs.values())
        besides = f"besides {streams:.1f} of the streams, which need {needed:.1f}"
        found.append(f"in a test {free:.1f} Mbit/s were free {besides}")
        fix = "" if free + streams >= needed else _what_fits(free + streams, needs, config)
        fix_of_drops = fix or _NOT_THE_LINK
    else:
        found.append(f"what more it carries is not known: {why_not_tried}")
        fix = "look again in a minute; an app that knows no link test needs an update"
        fix_of_drops = _BETTER_LINK_OR_LESS
    if lowered:
        found.append(lowered)
    if dropped := int(numbers["dropped"]):
        found.append(f"{dropped} messages were dropped as the link or this machine was too slow")
        fix = fix_of_drops
    return Finding(_CHECK, "hint" if fix else "ok", "; ".join(found), fix, numbers)


def _what_fits(mbit_per_s: float, needs: Mapping[str, float], config: Config | None) -> str:
    """Returns what to do on a link that carries `mbit_per_s`, which is less than `needs`."""
    asked = {} if config is None else images_mbit_per_s(config)
    images = {id: needs[id] for id in asked if id in needs}
    if config is None or not images:
        return _BETTER_LINK_OR_LESS
    others = sum(needs.values()) - sum(images.values())
    return f"{advice(config, mbit_per_s - others, images)}; or {_BETTER_LINK}"


def _needs(rows: Rows, config: Config | None) -> dict[str, float]:
    """Returns what each stream needs at the rate and quality that the configuration asks for.

    For a stream that arrives as configured this is measured. For images that are lowered or do not
    arrive it is the forecast.
    """
    session = rows.get("session", {})
    forecast = {} if config is None else images_mbit_per_s(config)
    lowered = lowered_streams(rows.get(ADAPTATION, {}))
    needs: dict[str, float] = {}
    silent: set[str] = set()
    for row in _topics(rows):
        stream = row.get("stream", "")
        needs[stream] = needs.get(stream, 0.0) + _needed_mbit_per_s(row)
        if not _number(row, "rate_hz"):
            silent.add(stream)
    for id, mbit_per_s in forecast.items():
        is_refused = session.get(f"stream.{id}", "").startswith("refused")
        if not is_refused and (id in lowered or id in silent or id not in needs):
            needs[id] = mbit_per_s
    return needs


def _needed_mbit_per_s(topic: Row) -> float:
    """Returns the bandwidth of a topic, scaled to the expected rate if there is one."""
    mbit_per_s, rate_hz = _number(topic, "mbit_per_s"), _number(topic, "rate_hz")
    expected_hz = _number(topic, "expected_hz") or rate_hz
    return mbit_per_s * expected_hz / rate_hz if rate_hz else 0.0


def _arriving(rows: Rows) -> dict[str, float]:
    topics = _topics(rows)
    return {
        "arriving_mbit_per_s": round(sum(_number(row, "mbit_per_s") for row in topics), 2),
        "slowest_p99_ms": max((_number(row, "latency_p99_ms") for row in topics), default=0.0),
        "dropped": sum(int(_number(row, "dropped.queue_full")) for row in topics),
    }


def _topics(rows: Rows) -> list[Row]:
    return [row for row in rows.values() if "rate_hz" in row]


def _lowered(rows: Rows) -> str:
    row = rows.get(ADAPTATION, {})
    return row.get("message", "") if lowered_streams(row) else ""


def _tested(test: Row | str) -> dict[str, float]:
    if isinstance(test, str) or test.get("state") != "measured":
        return {}
    return {
        "free_mbit_per_s": _number(test, "free_mbit_per_s"),
        "streams_mbit_per_s": _number(test, "streams_mbit_per_s"),
        "filler_bytes": int(_number(test, "filler_bytes")),
        "duration_s": _number(test, "duration_s"),
    }


def _number(row: Row, key: str) -> float:
    """Returns a number of /diagnostics; 0 where another node has put something else."""
    number = number_of(row.get(key))
    return number if number is not None and 0 <= number <= _MOST else 0.0


def _why(test: Row | str) -> str:
    return test if isinstance(test, str) else test.get("message", "")

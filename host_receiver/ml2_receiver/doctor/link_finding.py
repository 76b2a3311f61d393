"""The judgement of the link by `ml2-receiver doctor`: what it carries, and what is needed of it."""

from collections.abc import Mapping

from ..configuration.config import Config
from ..configuration.forecast import images_mbit_per_s
from ..configuration.link_fit import advice
from ..topics.adaptation import ADAPTATION, lowered_streams
from .findings import Finding

_CHECK = "link to headset"
_BETTER_LINK = "use Wi-Fi of 5 or 6 GHz near its access point, or a cable"
_MORE_LINK = (
    f"{_BETTER_LINK}; or ask for less: fewer streams, a lower update_rate, color (JPEG) in place of"
    " raw cameras"
)
_LESS_LOAD = (
    "the link carries enough now: see whether this machine is busy, or the link worse at times, and"
    " look again"
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
    arriving, needed = numbers["arriving_mbit_per_s"], numbers["needed_mbit_per_s"]
    found = (
        f"{arriving:.1f} Mbit/s arrive, p99 of the slowest topic {numbers['slowest_p99_ms']:.1f} ms"
    )
    fix, less = "", _MORE_LINK
    if "free_mbit_per_s" in numbers:
        free, streams = numbers["free_mbit_per_s"], numbers["streams_mbit_per_s"]
        found += f"; in a test {free:.1f} Mbit/s were free besides {streams:.1f} of the streams"
        found += f", which need {needed:.1f}"
        is_enough = free + streams >= needed
        less = _LESS_LOAD if is_enough else _what_fits(free + streams, needs, config)
        fix = "" if is_enough else less
    else:
        found += f"; what more it carries is not known: {why_not_tried}"
        fix = "look again in a minute; an app that knows no link test needs an update"
    if lowered:
        found += f"; {lowered}"
    if dropped := int(numbers["dropped"]):
        found += f"; {dropped} messages were dropped as the link or this machine was too slow"
        fix = less
    return Finding(_CHECK, "hint" if fix else "ok", found, fix, numbers)


def _what_fits(mbit_per_s: float, needs: Mapping[str, float], config: Config | None) -> str:
    """Returns what to do on a link that carries so much and less than the streams need."""
    if config is None:
        return _MORE_LINK
    images = {id: needs[id] for id in images_mbit_per_s(config) if id in needs}
    others = sum(needs.values()) - sum(images.values())
    return f"{advice(config, mbit_per_s - others, images)}; or {_BETTER_LINK}"


def _needs(rows: Rows, config: Config | None) -> dict[str, float]:
    """Returns what each stream needs at the rate and quality that the configuration asks for.

    That is what arrives of it, or the forecast if it is lowered or does not arrive.
    """
    session = rows.get("session", {})
    forecast = {} if config is None else images_mbit_per_s(config)
    lowered = lowered_streams(rows.get(ADAPTATION, {}))
    needs: dict[str, float] = {}
    silent: set[str] = set()
    for row in _topics(rows):
        stream = row.get("stream", "")
        needs[stream] = needs.get(stream, 0.0) + _needed_mbit_per_s(row)
        if not float(row["rate_hz"]):
            silent.add(stream)
    for id, mbit_per_s in forecast.items():
        is_refused = session.get(f"stream.{id}", "").startswith("refused")
        if not is_refused and (id in lowered or id in silent or id not in needs):
            needs[id] = mbit_per_s
    return needs


def _needed_mbit_per_s(topic: Row) -> float:
    """Returns the bandwidth of a topic, scaled to the expected rate if there is one."""
    mbit_per_s, rate_hz = float(topic["mbit_per_s"]), float(topic["rate_hz"])
    return mbit_per_s * float(topic.get("expected_hz", rate_hz)) / rate_hz if rate_hz else 0.0


def _arriving(rows: Rows) -> dict[str, float]:
    topics = _topics(rows)
    return {
        "arriving_mbit_per_s": round(sum(float(row["mbit_per_s"]) for row in topics), 2),
        "slowest_p99_ms": max((float(row.get("latency_p99_ms", 0)) for row in topics), default=0.0),
        "dropped": sum(int(row.get("dropped.queue_full", 0)) for row in topics),
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
        "free_mbit_per_s": float(test["free_mbit_per_s"]),
        "streams_mbit_per_s": float(test["streams_mbit_per_s"]),
        "filler_bytes": int(test["filler_bytes"]),
        "duration_s": float(test["duration_s"]),
    }


def _why(test: Row | str) -> str:
    return test if isinstance(test, str) else test.get("message", "")

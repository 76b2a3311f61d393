"""Turns /diagnostics and the topic `config` into the state that the page shows."""

from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from ml2_receiver.printable import printable
from ml2_receiver.session.statistics import SHARES
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.adaptation import ADAPTATION, LOWERED, lowered_streams
from ml2_receiver.topics.judgement import read_judgements

from ..images.image_topic import image_topics
from ..monitoring.topic_table import Rows, number_of, topic_figures
from .losses import calls_of, losses_of, subscriptions_of

type Levels = Mapping[str, int]

_OK, _WARN = 0, 1
_SILENT = ("silent", "refused", "failed")
_MOST_NAMED, _FEW = 5, 2
_MOST_MODE = 100
# The rows whose words are facts, with the words for a row that is not there.
_FACTS = {"security": "not reported", "clock": "not synchronised yet", "link": "not tested"}


@dataclass(frozen=True)
class Fact:
    """One fact about the headset; `level` is that of diagnostic_msgs/DiagnosticStatus."""

    name: str
    text: str
    level: int = _OK


def image_streams(with_eyes: bool) -> tuple[str, ...]:
    """Returns the streams with images, in the order of the page; with or without eye cameras."""
    table = load_table()
    found = [
        it for it in table.streams if image_topics(it) and (with_eyes or not table.shows_eyes(it))
    ]
    # The wearer's view comes first, and eye cameras, which start hidden, come last.
    first = ("color", "mixed_reality", "depth", "infra")
    return tuple(sorted(found, key=lambda it: (table.shows_eyes(it), it not in first)))


def known_topics(rows: Rows) -> dict[str, Topic]:
    """Returns the topics of the stream table by their full names, if they have its types."""
    return {
        name: topic
        for name, values in rows.items()
        if (topic := _topic(name, values)) is not None and values.get("type") == topic.type
    }


def _topic(name: str, values: Mapping[str, str]) -> Topic | None:
    """Returns the topic of the stream table that a row is about."""
    stream = load_table().streams.get(values.get("stream", ""))
    if stream is None or "type" not in values:
        return None
    ours = [it for it in stream.topics if f"/{name}".endswith(f"/{it.name}")]
    # The name of a topic may end with that of another one.
    return max(ours, key=lambda it: len(it.name), default=None)


def published_images(rows: Rows) -> dict[str, tuple[str, str]]:
    """Returns name and type of the image topic of each requested stream, if it is published."""
    session = rows.get("session", {})
    return {
        topic.stream: (name, topic.type)
        for name, topic in known_topics(rows).items()
        # A topic stays after its stream, which only the session does not name then. It also stays
        # when the stream has another format.
        if topic.role == "image" and f"state.{topic.stream}" in session
        if "needs" not in rows[name]
    }


def topic_prefix(rows: Rows) -> str | None:
    """Returns the prefix of the receiver's topics; None while it lists none."""
    for name, topic in known_topics(rows).items():
        if not topic.name.startswith("/"):
            return name.removesuffix(f"/{topic.name}")
    return None


def state_of(
    rows: Rows,
    levels: Levels,
    modes: Mapping[str, str],
    battery: str,
    recent: Mapping[str, int] | None = None,
) -> dict[str, Any]:
    """Returns the state as an object for JSON. What the rows do not say is None.

    Args:
        levels: the level of each row.
        modes: the mode of each camera in words.
        battery: the charge of the battery in words.
        recent: how many messages each topic has lost in the last 10 s.
    """
    recent = recent or {}
    images = {stream: name for stream, (name, _) in published_images(rows).items()}
    figures = {it["topic"]: it for it in topic_figures(rows)}
    lowered = lowered_streams(rows.get(ADAPTATION, {}))
    return {
        "type": "state",
        "facts": [asdict(it) for it in _facts(rows, levels, battery)],
        "streams": [
            _stream(it, figures[images[it]], levels.get(images[it], _OK))
            | {"mode": modes.get(it, ""), "lowered": lowered.get(it, "")}
            | {"rate_hz": _shown_hz(figures[images[it]]), "lost": recent.get(images[it], 0)}
            | {"stages_ms": _stages_ms(rows[images[it]])}
            for it in image_streams(with_eyes=True)
            if it in images
        ],
        "applied": _applied(rows, modes),
        "warnings": [
            *_missing_permissions(rows),
            *_silences(rows, images),
            *_warnings(rows, levels),
            *_unknown_types(rows),
        ],
        "losses": losses_of(figures, recent),
        "subscriptions": subscriptions_of(rows),
        "calls": calls_of(rows),
    }


def recorded_state(
    rows: Rows, facts: Mapping[str, str], rates_hz: Mapping[str, float], modes: Mapping[str, str]
) -> dict[str, Any]:
    """Returns the state of a recording as an object for JSON; what it cannot say is None.

    Args:
        facts: the words of each fact.
        rates_hz: the rate of each topic.
    """
    unknown = dict.fromkeys(("expected_hz", "latency_p50_ms", "latency_p99_ms", "lost"))
    images = published_images(rows)
    return {
        "type": "state",
        "facts": [asdict(Fact(name, text)) for name, text in facts.items()],
        "streams": [
            {
                "id": it,
                "is_eye": load_table().shows_eyes(it),
                "level": _OK,
                "topic": topic,
                "state": "",
            }
            | {"stages_ms": None}
            | {"rate_hz": rates_hz.get(topic), "mode": modes.get(it, ""), "lowered": ""}
            | unknown
            for it in image_streams(with_eyes=True)
            if it in images
            for topic in images[it][:1]
        ],
        "applied": {},
        "warnings": [],
        "losses": [],
        "subscriptions": [],
        "calls": [],
    }


def mode_in_words(values: Mapping[str, Any] | None) -> str:
    """Returns a camera's applied values, such as "1016x1016@30 jpeg"; empty without a mode."""
    keys = ("resolution_width", "resolution_height", "update_rate", "format")
    if values is None or not all(key in values for key in keys):
        return ""
    return printable("{}x{}@{} {}".format(*(values[key] for key in keys)), _MOST_MODE)


def _facts(rows: Rows, levels: Levels, battery: str) -> list[Fact]:
    session = rows.get("session", {})
    headset = f"{session.get('headset', 'no headset yet')}, {session.get('state', 'waiting')}"
    is_lost = session.get("state") == "lost"
    return [
        Fact("headset", headset, _WARN if is_lost else _OK),
        *(
            Fact(name, rows.get(name, {}).get("message", otherwise), levels.get(name, _OK))
            for name, otherwise in _FACTS.items()
        ),
        Fact("recording", _recording(rows.get("recording")), levels.get("recording", _OK)),
        Fact("heat", session.get("thermal", "not reported")),
        Fact("battery", battery),
    ]


def _recording(values: Mapping[str, str] | None) -> str:
    if values is None:
        return "off"
    file_bytes, seconds = number_of(values.get("file_bytes")), number_of(values.get("duration_s"))
    if file_bytes is None or seconds is None:
        return values.get("message", "")
    return f"{values.get('state', 'on')}, {seconds:.0f} s, {file_bytes / 1e6:.1f} MB"


def _stream(stream: str, figures: Mapping[str, Any], level: int) -> dict[str, Any]:
    same = ("topic", "rate_hz", "expected_hz", "latency_p50_ms", "latency_p99_ms", "lost")
    # The words of a running stream are about its losses, which have a place of their own.
    words = "" if figures["stream_state"] == "running" else figures["state"]
    return {
        "id": stream,
        "is_eye": load_table().shows_eyes(stream),
        "level": level,
        "state": words,
    } | {key: figures[key] for key in same}


def _shown_hz(figures: Mapping[str, Any]) -> float | None:
    """Returns the rate of the last second without the late messages of the second before."""
    rate_hz, expected_hz = figures["rate_hz"], figures["expected_hz"]
    if rate_hz is None or expected_hz is None:
        return None if rate_hz is None else float(rate_hz)
    return float(min(rate_hz, expected_hz))


def _stages_ms(row: Mapping[str, str]) -> list[float] | None:
    """Returns the means of SHARES over the last second; None if the headset knows no ROS time."""
    keys = [f"window.{share}_ms" for share in SHARES]
    stages_ms = [it for key in keys if (it := number_of(row.get(key))) is not None]
    return stages_ms if len(stages_ms) == len(keys) else None


def _missing_permissions(rows: Rows) -> list[dict[str, Any]]:
    """Returns a warning for each permission that requested streams wait for."""
    waiting = defaultdict[str, list[str]](list)
    for stream, it in read_judgements(rows.get("session", {})).items():
        if it.permission is not None:
            waiting[it.permission].append(stream)
    return [
        {
            "row": f"permission {permission} is missing",
            "text": f"grant it with `ml2-receiver headset grant {' '.join(streams)}`",
            "level": _WARN,
        }
        for permission, streams in waiting.items()
    ]


def _silences(rows: Rows, shown: Collection[str]) -> list[dict[str, Any]]:
    """Returns a warning for each requested stream that does not deliver, and has no image."""
    return [
        {"row": stream, "text": it.text, "level": _WARN}
        for stream, it in read_judgements(rows.get("session", {})).items()
        if it.state in _SILENT and it.permission is None and stream not in shown
    ]


def _applied(rows: Rows, modes: Mapping[str, str]) -> dict[str, str]:
    """Returns in words what the headset does with the streams of each requested section."""
    session, found = rows.get("session", {}), defaultdict[str, list[str]](list)
    for stream, it in load_table().streams.items():
        if (state := session.get(f"state.{stream}")) is None:
            continue
        answer = session.get(f"stream.{stream}", "")
        words = (state, modes.get(stream, ""), answer if answer.startswith("adjusted") else "")
        found[it.section].append(", ".join(filter(None, words)))
    return {section: "; ".join(dict.fromkeys(words)) for section, words in found.items()}


def _warnings(rows: Rows, levels: Levels) -> list[dict[str, Any]]:
    """Returns the rows that warn, the worst first; topics and facts have places of their own."""
    found = [
        {"row": name, "text": _words(name, values), "level": levels[name]}
        for name, values in rows.items()
        if levels.get(name, _OK) > _OK and "type" not in values and name not in _FACTS
    ]
    return sorted(found, key=lambda it: -it["level"])


def _words(name: str, values: Mapping[str, str]) -> str:
    """Returns the words of a row, without names that the page has below the images."""
    count = len(lowered_streams(values)) if name == ADAPTATION else 0
    return values.get("message", "") if count <= _FEW else f"{LOWERED}: {count} streams, see below"


def _unknown_types(rows: Rows) -> list[dict[str, Any]]:
    """Returns a warning for the first topics of the stream table that have other types than it."""
    known = known_topics(rows)
    return [
        {"row": name, "text": f"expected {topic.type}, found {found['type']}", "level": _WARN}
        for name, found in rows.items()
        if name not in known and (topic := _topic(name, found)) is not None
    ][:_MOST_NAMED]

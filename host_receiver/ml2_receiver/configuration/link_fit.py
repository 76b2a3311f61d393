"""Finds the mildest change of a configuration with which its images fit a link."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ..table.reader import load_table
from ..table.stream_table import VIDEO, Mode, Stream
from ..wire.json_body import Scalar
from .config import Config
from .config_rules import Values
from .forecast import images_mbit_per_s, stream_mbit_per_s

# The values of each enabled stream of images.
type _Requests = Mapping[str, Values]


@dataclass(frozen=True)
class Change:
    """Other values by "section.key", with which the images need `mbit_per_s`."""

    values: Mapping[str, Scalar]
    mbit_per_s: float


def link_in_words(config: Config, needs: Mapping[str, float], mbit_per_s: float | None) -> str:
    """Says what images need of the link and, if that is too much, what to do.

    Args:
        needs: what each stream of images needs, in Mbit/s.
        mbit_per_s: what the link carries; None if it is not known.
    """
    if not needs:
        return "no images"
    words = f"images need about {sum(needs.values()):.0f} Mbit/s"
    if mbit_per_s is None:
        return words
    if sum(needs.values()) <= mbit_per_s:
        return f"{words}, within the link's {mbit_per_s:g}"
    return f"{words}, more than the link's {mbit_per_s:g}: {advice(config, mbit_per_s, needs)}"


def bound_mbit_per_s(config: Config) -> float | None:
    """Returns what images may need together by general.link; None if it is no number."""
    return None if config.link is None else config.link.most_mbit_per_s


def advice(config: Config, mbit_per_s: float, needs: Mapping[str, float]) -> str:
    """Says what to do on a link that carries `mbit_per_s` of images, which need more.

    Args:
        needs: what each stream of images needs, in Mbit/s.
    """
    change = fitting_change(config, mbit_per_s, needs)
    if change is not None:
        less = f"images then need about {change.mbit_per_s:.0f} Mbit/s"
        return f"run `{_set(change.values, config)}`: {less}"
    if config.link is None:
        less = "the headset then lowers quality and rates to what the link carries"
        return f"run `{_set({'general.link': 'auto'}, config)}`: {less}"
    return "leave it to the headset, which lowers quality and rates to what the link carries"


def fitting_change(config: Config, mbit_per_s: float, needs: Mapping[str, float]) -> Change | None:
    """Finds the mildest change with which images need at most `mbit_per_s`; None if there is none.

    First formats are compressed, then qualities of JPEG lowered, then rates, then streams disabled.
    Streams give way in the table's order of adaptation. Those of its last line stay enabled.

    Args:
        needs: the streams to look at, and what each needs now, in Mbit/s.
    """
    streams, forecast = load_table().streams, images_mbit_per_s(config)
    before = {id: config.requests[id] for id in needs}
    scale = {id: needs[id] / forecast[id] for id in needs}
    for after in _milder_first(before):
        needed = sum(scale[id] * stream_mbit_per_s(streams[id], it) for id, it in after.items())
        if needed <= mbit_per_s:
            return Change(_difference(before, after), needed)
    return None


def _milder_first(requests: _Requests) -> Iterator[_Requests]:
    """Yields the requests unchanged, then with one more step each time."""
    order = load_table().adaptation
    groups = [group for it in order.streams if (group := [id for id in it if id in requests])]
    yield requests
    for group in groups:
        requests = {**requests, **{id: _compressed(id, requests[id]) for id in group}}
        yield requests
    for quality in order.quality:
        for group in groups:
            requests = {**requests, **{id: _at_most(quality, requests[id]) for id in group}}
            yield requests
    for group in groups:
        while slower := {id: it for id in group if (it := _slower(id, requests[id]))}:
            requests = {**requests, **slower}
            yield requests
    for group in groups[:-1]:
        requests = {id: it for id, it in requests.items() if id not in group}
        yield requests


def _compressed(id: str, values: Values) -> Values:
    """Returns the values with the format of the same stream that needs least, but no video."""
    stream = load_table().streams[id]
    formats = (stream.when or {}).get("format")
    found = [
        {**values, "format": format}
        for mode in _modes_of_size(stream, values)
        for format in (mode.formats if values["update_rate"] in mode.rates else ())
        if format not in VIDEO and (formats is None or format in formats)
    ]
    return min([values, *found], key=lambda it: stream_mbit_per_s(stream, it))


def _at_most(quality: int, values: Values) -> Values:
    if values["format"] != "jpeg" or "quality" not in values:
        return values
    return {**values, "quality": min(quality, int(values["quality"]))}


def _slower(id: str, values: Values) -> Values | None:
    """Returns the values with the next lower rate of the camera; None if it has none."""
    stream = load_table().streams[id]
    modes = [it for it in _modes_of_size(stream, values) if values["format"] in it.formats]
    found = [{**values, "update_rate": rate} for it in modes for rate in it.rates]
    needed = stream_mbit_per_s(stream, values)
    lower = [it for it in found if stream_mbit_per_s(stream, it) < needed]
    return max(lower, key=lambda it: int(it["update_rate"]), default=None)


def _difference(before: _Requests, after: _Requests) -> dict[str, Scalar]:
    streams = load_table().streams
    found: dict[str, Scalar] = {}
    for id, values in before.items():
        section = streams[id].section
        if id not in after:
            found[f"{section}.enabled"] = False
            continue
        changed = [(key, value) for key, value in after[id].items() if value != values[key]]
        found |= {f"{section}.{key}": value for key, value in changed}
    return found


def _set(values: Mapping[str, Scalar], config: Config) -> str:
    words = " ".join(f"{key}={_shown(value)}" for key, value in values.items())
    return f"ml2-receiver set {words}" + (f" --name {config.name}" if config.name else "")


def _shown(value: Scalar) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _modes_of_size(stream: Stream, values: Values) -> Iterator[Mode]:
    """Yields the camera's modes with the `stream` and resolution of `values`."""
    size = values["resolution_width"], values["resolution_height"]
    for mode in load_table().sections[stream.section].modes:
        if mode.stream == values["stream"] and size in mode.resolutions:
            yield mode

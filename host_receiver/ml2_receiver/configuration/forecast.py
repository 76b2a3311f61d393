"""Forecasts what the images of a configuration need of the link, and what would need less."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from ..table.reader import load_table
from ..table.stream_table import Mode, Stream, Topic
from ..wire.json_body import Scalar
from .config import Config
from .config_rules import Values

_TABLE_QUALITY = 80
# Depth's confidence and flags, which are never compressed.
_OTHER_BITS_PER_PIXEL = 32.0


@dataclass(frozen=True)
class Change:
    """Other values by "section.key", with which the images need `mbit_per_s`."""

    values: Mapping[str, Scalar]
    mbit_per_s: float


def images_mbit_per_s(config: Config) -> dict[str, float]:
    """Returns what each enabled stream of images needs, by its size, rate, format and quality.

    The sizes of compressed images depend on what the camera sees: theirs are estimates.
    """
    table = load_table()
    return {
        id: _mbit_per_s(table.streams[id], values)
        for id, values in config.requests.items()
        if id in table.image_lanes
    }


def needs_in_words(needs: Mapping[str, float]) -> str:
    """Says what streams of images need together; `needs` is in Mbit/s."""
    return f"images need about {sum(needs.values()):.0f} Mbit/s" if needs else "no images"


def fitting_change(
    config: Config, mbit_per_s: float, needs: Mapping[str, float] | None = None
) -> Change | None:
    """Finds a change with which the images need at most `mbit_per_s`; None if there is none.

    Raw images are compressed first, then rates are lowered, what saves most before the rest.

    Args:
        needs: the streams to look at, and what each needs now; by default all by the forecast.
    """
    streams = load_table().streams
    needed = dict(images_mbit_per_s(config) if needs is None else needs)
    requests = {id: dict(config.requests[id]) for id in needed}
    changes: dict[str, Scalar] = {}
    for alternative in (_compressed, _slower):
        while sum(needed.values()) > mbit_per_s:
            found = [
                (id, change, needed[id] * _share(streams[id], requests[id], change))
                for id in needed
                for change in alternative(streams[id], requests[id])
            ]
            if not found:
                break
            id, change, less = max(found, key=lambda it: needed[it[0]] - it[2])
            requests[id] |= change
            needed[id] = less
            changes |= {f"{streams[id].section}.{key}": value for key, value in change.items()}
    total = sum(needed.values())
    return Change(changes, total) if total <= mbit_per_s else None


def _mbit_per_s(stream: Stream, values: Values) -> float:
    topics = [it for it in stream.topics if it.lane == stream.id]
    bits_per_pixel = sum(
        _bits_per_pixel(it, values) for it in topics if it.when is None or it.when.holds(values)
    )
    pixels = float(values["resolution_width"]) * float(values["resolution_height"])
    return pixels * bits_per_pixel * _delivered_hz(stream, values) / 1e6


def _bits_per_pixel(topic: Topic, values: Values) -> float:
    if topic.role != "image":
        return _OTHER_BITS_PER_PIXEL
    format = str(values["format"])
    bits_per_pixel = load_table().image_sizes.bits_per_pixel[format]
    if format != "jpeg":
        return bits_per_pixel
    return bits_per_pixel * _relative_size(float(values.get("quality", _TABLE_QUALITY)))


def _relative_size(quality: float) -> float:
    """Returns the size of a JPEG relative to that at quality 80."""
    sizes = sorted(load_table().image_sizes.jpeg_by_quality.items())
    for (low, size), (high, larger) in pairwise(sizes):
        if quality <= high:
            return size + (larger - size) * (quality - low) / (high - low)
    return sizes[-1][1]


def _delivered_hz(stream: Stream, values: Values) -> float:
    rate = int(values["update_rate"])
    delivers = [it.delivers for it in _modes(stream, values) if rate in it.rates]
    return delivers[0].get(rate, rate) if delivers else rate


def _modes(stream: Stream, values: Values) -> Iterator[Mode]:
    """Yields the modes of the camera that have these values, but for its rate and format."""
    size = values["resolution_width"], values["resolution_height"]
    for mode in load_table().sections[stream.section].modes:
        if mode.stream == values["stream"] and size in mode.resolutions:
            yield mode


def _share(stream: Stream, values: Values, change: Values) -> float:
    """Returns what the stream needs after a change, relative to before."""
    return _mbit_per_s(stream, {**values, **change}) / _mbit_per_s(stream, values)


def _compressed(stream: Stream, values: Values) -> Iterator[Values]:
    """Yields the other formats of the same stream that need less."""
    formats = (stream.when or {}).get("format")
    for mode in _modes(stream, values):
        for format in mode.formats if values["update_rate"] in mode.rates else ():
            change = {"format": format}
            is_of_stream = formats is None or format in formats
            if is_of_stream and _share(stream, values, change) < 1:
                yield change


def _slower(stream: Stream, values: Values) -> Iterator[Values]:
    """Yields the next lower rate of the camera, if it has one."""
    rates = {
        rate for it in _modes(stream, values) if values["format"] in it.formats for rate in it.rates
    }
    lower = [it for it in rates if _share(stream, values, {"update_rate": it}) < 1]
    if lower:
        yield {"update_rate": max(lower)}

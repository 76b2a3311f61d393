"""Forecasts what the images of a configuration need of the link."""

from itertools import pairwise

from ..table.reader import load_table
from ..table.stream_table import VIDEO, Stream, Topic
from .config import Config
from .config_rules import Values

_TABLE_QUALITY = 80
# Depth's confidence and flags, which are never compressed.
_OTHER_BITS_PER_PIXEL = 32.0


def images_mbit_per_s(config: Config) -> dict[str, float]:
    """Returns what each enabled stream of images needs, by its size, rate, format and quality.

    The size of a compressed image depends on what the camera sees, so its need is an estimate.
    """
    table = load_table()
    return {
        id: stream_mbit_per_s(table.streams[id], values)
        for id, values in config.requests.items()
        if table.streams[id].images
    }


def stream_mbit_per_s(stream: Stream, values: Values) -> float:
    """Returns what a stream of images needs with these values."""
    if values["format"] in VIDEO:
        return float(values["bit_rate_mbit"])
    bits_per_pixel = sum(
        _bits_per_pixel(topic, values)
        for topic in stream.images
        if topic.when is None or topic.when.holds(values)
    )
    pixels = float(values["resolution_width"]) * float(values["resolution_height"])
    return pixels * bits_per_pixel * int(values["update_rate"]) / 1e6


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

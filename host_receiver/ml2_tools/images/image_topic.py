"""Finds the image topic of a camera, which is compressed or not, and the camera of a topic."""

from collections.abc import Callable

from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic

_TRANSPORTS = ("/compressed", "/compressedDepth", "/ffmpeg", "/foxglove")


def image_topics(camera: str) -> tuple[Topic, ...]:
    """Returns the image topics of a stream, of which a headset publishes one; the raw one first."""
    return tuple(it for it in load_table().streams[camera].topics if it.role == "image")


def image_topic(camera: str, prefix: str, exists: Callable[[str], object]) -> Topic:
    """Returns the image topic of a stream that is recorded or published.

    If several exist, it is the compressed one, because `ml2-receiver products` makes the raw one
    from it. If none exists, it is the first one in the stream table.

    Args:
        prefix: the prefix of the headset's topics.
        exists: returns a true value for the absolute name of a topic that exists.
    """
    first, *compressed = image_topics(camera)
    return next((it for it in compressed if exists(it.full_name(prefix))), first)


def camera_namespace(name: str) -> str:
    """Returns the name before /camera_info of an image topic's camera, such as "/p/world_left"."""
    for transport in _TRANSPORTS:
        name = name.removesuffix(transport)
    return name.rpartition("/")[0]

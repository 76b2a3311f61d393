"""Topics of a receiver on Zenoh, for programs of others that read them."""

from collections.abc import Iterator
from contextlib import contextmanager

import zenoh

import ros_messages
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.sink import ZenohSink
from zenoh_peers import free_endpoint, open_router

DOMAIN, PREFIX = 9, "/robot1/magic_leap2"
_TABLE = load_table()


def _topic(stream: str, role: str, suffix: str = "") -> Topic:
    topics = _TABLE.streams[stream].topics
    return next(it for it in topics if it.role == role and it.name.endswith(suffix))


IMAGE = _topic("world_left", "image", "image_raw")
METADATA = _topic("world_left", "metadata")
IMU = _topic("gyro_left", "imu")
STATIC = _topic("tf", "tf_static")


@contextmanager
def routed_sink() -> Iterator[tuple[str, ZenohSink]]:
    """A router of its own, and a sink that publishes there."""
    endpoint = free_endpoint()
    with (
        open_router(endpoint),
        zenoh.open(session_configuration(endpoint, None)) as session,
    ):
        sink = ZenohSink(session, _TABLE, PREFIX, "robot1", DOMAIN, lambda: None)
        yield endpoint, sink
        sink.close()


def open_topics(sink: ZenohSink) -> dict[str, str]:
    """Opens the topics above; returns the names of all topics with their types."""
    opened = (IMU, IMAGE, METADATA, STATIC)
    for it in opened:
        sink.open(it)
    types = {it.full_name(PREFIX): it.type for it in opened}
    types |= {f"{PREFIX}/{it.name}": it.type for it in _TABLE.receiver_topics}
    return types | {"/diagnostics": "diagnostic_msgs/msg/DiagnosticArray"}


def imu() -> bytes:
    header = ros_messages.header("gyro_left", 17)
    return ros_messages.imu(header, (0.25, -1.5, 3.0), (0.0, 9.75, 0.0))

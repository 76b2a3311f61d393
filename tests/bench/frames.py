"""The frames that the receiver's benchmarks send, and their topics in ROS."""

import itertools
from collections.abc import Callable, Mapping

import numpy as np
from rosbags.typesys import Stores, get_typestore

from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.frame import CDR_ENCAPSULATION, encode_frame
from ml2_receiver.wire.json_body import Scalar
from ml2_receiver.wire.kinds import Kind
from mock_device import MockDevice

PREFIX = "/bench"
CONFIG = f"/**: {{ros__parameters: {{general: {{topic_name: {PREFIX}}}}}}}".encode()
REQUEST: Mapping[str, Mapping[str, Scalar]] = {
    "world_left": {"stream": 0, "format": "Grayscale"},
    "gyro_left": {},
}
IMAGE = load_table().streams["world_left"].topics[0]
IMU = load_table().streams["gyro_left"].topics[0]
DEPTH = load_table().qos[IMAGE.qos].depth
RECEIVER_TOPIC = IMAGE.full_name(PREFIX)
BARE_TOPIC, ENDPOINT_TOPIC = f"{PREFIX}/bare", f"{PREFIX}/endpoint"
_SEQUENCE = slice(8, 12)


def _image() -> bytes:
    """Returns a serialized mono8 image of 1016 x 1016; only ROS-TCP-Endpoint decodes it."""
    types = get_typestore(Stores.ROS2_JAZZY)
    time = types.types["builtin_interfaces/msg/Time"](0, 0)
    header = types.types["std_msgs/msg/Header"](time, IMAGE.frame)
    pixels = np.random.default_rng(1).integers(0, 256, 1016 * 1016, np.uint8)
    image = types.types[IMAGE.type](header, 1016, 1016, "mono8", 0, 1016, pixels)
    return bytes(types.serialize_cdr(image, IMAGE.type))


IMAGE_PAYLOAD = _image()
# As large as a sensor_msgs/Imu.
IMU_PAYLOAD = CDR_ENCAPSULATION + bytes(324)


def sender(device: MockDevice, topic: Topic, payload: bytes) -> Callable[[], None]:
    """Returns a function that sends the topic's next frame; only its sequence number changes."""
    channel = device.number(topic.name)
    frame = bytearray(encode_frame(Kind.DATA, payload, channel=channel))
    numbers = itertools.count()

    def send() -> None:
        frame[_SEQUENCE] = next(numbers).to_bytes(4, "little")
        device.wires[topic.lane.name].socket.sendall(frame)

    return send

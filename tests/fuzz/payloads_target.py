"""Messages that are looked into on this side of ROS."""

from collections.abc import Iterator
from contextlib import suppress

from ml2_receiver.configuration.calibration import Calibration
from ml2_receiver.errors import PublishError
from ml2_receiver.ros.layout import plain
from ml2_receiver.topics.calibrated_sink import CameraInfoOverride
from ml2_receiver.topics.plain_messages import decode_string, encode_string
from ml2_receiver.topics.stamps import stamp_reader
from ml2_receiver.wire.frame import CDR_ENCAPSULATION
from vectors import vectors

_STAMPED = ("sensor_msgs/msg/CameraInfo", "std_msgs/msg/String", "tf2_msgs/msg/TFMessage")
_LAYOUTS = ("s", "[44ssddddddd]", "44s44s[d](d*9)(d*9)(d*12)444444b", "[[w](s*3)]")
_CALIBRATION = Calibration(1016, 1016, "plumb_bob", (0.0,) * 5, (1.0,) * 9, (1.0,) * 9, (1.0,) * 12)


def seeds() -> Iterator[bytes]:
    for names in ("CameraInfo*", "String*", "TFMessage*"):
        for _, data in vectors("cdr", names):
            yield data
            yield b"\0\0" + data[2:]
    yield encode_string('{"stamp": {"sec": 12, "nanosec": 34}}')


def read(data: bytes) -> None:
    for message_type in _STAMPED:
        with suppress(ValueError):
            stamp_reader(message_type)(data)
    with suppress(ValueError):
        text = decode_string(data)
        assert text in data
    for layout in _LAYOUTS:
        with suppress(ValueError):
            assert plain(data, layout).startswith(CDR_ENCAPSULATION)
    payload = bytearray(data)
    with suppress(PublishError):
        changed = CameraInfoOverride(_CALIBRATION).apply(payload)
        assert changed is payload or changed[:16] == payload[:16]

"""Overridden CameraInfo, read by rosbags, of payloads that rclpy wrote."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo

from configurations import DOCUMENT, calibration_yaml
from fake_sink import FakeSink
from ml2_receiver.configuration.calibration import Calibration, load_calibration
from ml2_receiver.errors import PublishError
from ml2_receiver.session.sink import Applied
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.calibrated_sink import CalibratedSink
from ml2_receiver.wire.messages import StreamAnswer, StreamStatus
from ros_messages import TYPES

STREAM = load_table().streams["world_left"]
TOPIC = next(topic for topic in STREAM.topics if topic.role == "camera_info")


def payload(frame_id: str, width: int = 1016, model: str = "plumb_bob") -> bytearray:
    info = CameraInfo(width=width, height=1016, distortion_model=model, d=[1.0, 2.0], binning_x=3)
    info.header.frame_id = frame_id
    info.header.stamp.sec, info.header.stamp.nanosec = 12, 34
    return bytearray(serialize_message(info))


def decoded(data: bytes) -> Any:
    return TYPES.deserialize_cdr(data, TOPIC.type)


def calibration(folder: Path, **changes: object) -> Calibration:
    file = folder / "calibration.yaml"
    file.write_text(calibration_yaml(**changes))
    return load_calibration(file)


def numbers(key: str) -> list[float]:
    matrix: Any = DOCUMENT[key]
    return list(map(float, matrix["data"]))


@pytest.mark.parametrize(
    "model", [("equidistant", 4), ("plumb_bob", 5), ("rational_polynomial", 8)]
)
@pytest.mark.parametrize(
    "frame_id", ["", "a", "ab", "abc", "abcd", "world_left_optical_frame", "ü"]
)
def test_values_are_the_users_and_the_header_is_the_devices(
    tmp_path: Path, frame_id: str, model: tuple[str, int]
) -> None:
    name, count = model
    d = {"rows": 1, "cols": count, "data": [0.25 * it for it in range(count)]}
    its = calibration(tmp_path, distortion_model=name, distortion_coefficients=d)
    fake = FakeSink()
    publish = CalibratedSink(fake, {"world_left": its}).open(TOPIC)
    publish(payload(frame_id))
    publish(payload(frame_id + "_longer"))
    publish(payload(frame_id))
    first, other, again = map(decoded, fake.payloads[TOPIC.name])
    for info, frame in ((first, frame_id), (other, frame_id + "_longer"), (again, frame_id)):
        assert info.header.frame_id == frame
        assert (info.header.stamp.sec, info.header.stamp.nanosec) == (12, 34)
        assert (info.width, info.height) == (1016, 1016)
        assert info.distortion_model == name
        assert list(info.d) == d["data"]
        assert list(info.k) == numbers("camera_matrix")
        assert list(info.r) == numbers("rectification_matrix")
        assert list(info.p) == numbers("projection_matrix")
        assert (info.binning_x, info.binning_y, info.roi.width, info.roi.do_rectify) == (0, 0, 0, 0)


def test_images_of_another_size_keep_the_devices_values(tmp_path: Path) -> None:
    fake = FakeSink()
    publish = CalibratedSink(fake, {"world_left": calibration(tmp_path)}).open(TOPIC)
    untouched = payload("frame", width=640)
    publish(bytearray(untouched))
    assert fake.payloads[TOPIC.name] == [untouched]


@pytest.mark.parametrize("width", [1016, 640])
def test_a_headset_that_adjusts_the_resolution_is_told_of_once(tmp_path: Path, width: int) -> None:
    fake = FakeSink()
    sink = CalibratedSink(fake, {"world_left": calibration(tmp_path)})
    values = {"resolution_width": width, "resolution_height": 1016}
    applied = Applied("it", "session", {"world_left": StreamAnswer("applied", values)}, [])
    lowered = replace(applied, states={"world_left": StreamStatus("running", rate_hz=15)})
    sink.configured(applied)
    sink.configured(lowered)
    assert fake.applied == [applied, lowered]
    expected = [
        "world_left: the calibration is for 1016x1016, but the headset sends 640x1016:"
        " its own camera_info is published"
    ]
    assert fake.events == ([] if width == 1016 else expected)


def test_everything_else_passes_as_it_is(tmp_path: Path) -> None:
    fake = FakeSink()
    sink = CalibratedSink(fake, {"world_left": calibration(tmp_path)})
    image = STREAM.topics[0]
    other = next(
        topic for topic in load_table().streams["world_right"].topics if topic.role == "camera_info"
    )
    for topic in (image, other):
        sink.open(topic)(payload("frame"))
        assert fake.payloads[topic.name] == [payload("frame")]


def test_another_calibration_counts_from_the_next_message_on(tmp_path: Path) -> None:
    fake = FakeSink()
    sink = CalibratedSink(fake, {})
    publish = sink.open(TOPIC)
    publish(payload("frame"))
    sink.use({"world_left": calibration(tmp_path)})
    publish(payload("frame"))
    assert [decoded(it).k[0] for it in fake.payloads[TOPIC.name]] == [0, 580.5]


@pytest.mark.parametrize("length", [4, 8, 12, 15, 20, 25])
def test_a_payload_that_is_cut_short_is_not_published(tmp_path: Path, length: int) -> None:
    fake = FakeSink()
    publish = CalibratedSink(fake, {"world_left": calibration(tmp_path)}).open(TOPIC)
    with pytest.raises(PublishError, match=f"camera_info of {length} bytes"):
        publish(payload("abcdef")[:length])


def test_a_header_that_claims_more_than_there_is_is_not_published(tmp_path: Path) -> None:
    fake = FakeSink()
    publish = CalibratedSink(fake, {"world_left": calibration(tmp_path)}).open(TOPIC)
    lying = payload("frame")
    lying[12:16] = b"\xff\xff\xff\xff"
    with pytest.raises(PublishError):
        publish(lying)

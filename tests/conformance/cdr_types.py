"""The fields of each message type of the product, with the values of the cases."""

import math
from collections.abc import Mapping, Sequence

from cdr_message import Message

OPTICAL = "world_left_optical_frame"


def time(m: Message, sec: int, nanosec: int) -> None:
    m.int32("sec", sec)
    m.uint32("nanosec", nanosec)


def header_fields(m: Message, frame_id: str) -> None:
    with m.nested("stamp"):
        time(m, 1_700_000_000, 123_456_789)
    m.string("frame_id", frame_id)


def header(m: Message, frame_id: str) -> None:
    with m.nested("header"):
        header_fields(m, frame_id)


def xyz(m: Message, x: float, y: float, z: float) -> None:
    """Vector3 or Point."""
    m.float64("x", x)
    m.float64("y", y)
    m.float64("z", z)


def quaternion(m: Message, x: float, y: float, z: float, w: float) -> None:
    xyz(m, x, y, z)
    m.float64("w", w)


def pose(m: Message, x: float) -> None:
    with m.nested("position"):
        xyz(m, x, -2.25, 0.1)
    with m.nested("orientation"):
        quaternion(m, -0.5, 0.5, -0.5, 0.5)


def pose_stamped(m: Message) -> None:
    header(m, "magicleap_world")
    with m.nested("pose"):
        pose(m, 1.5)


def pose_array(m: Message, xs: Sequence[float]) -> None:
    header(m, "magicleap_world")
    m.message_sequence("poses", xs, lambda x: pose(m, x))


def pose_with_covariance(m: Message) -> None:
    with m.nested("pose"):
        pose(m, 1.5)
    m.float64_array("covariance", [index / 10 for index in range(36)])


def transform(m: Message, x: float) -> None:
    with m.nested("translation"):
        xyz(m, x, 0.2, -1e-9)
    with m.nested("rotation"):
        quaternion(m, 0.0, 0.0, 0.6, 0.8)


def transform_stamped(m: Message, parent: str, child: str, x: float = 0.25) -> None:
    header(m, parent)
    m.string("child_frame_id", child)
    with m.nested("transform"):
        transform(m, x)


def tf_message(m: Message, children: Sequence[str]) -> None:
    m.message_sequence(
        "transforms",
        list(enumerate(children)),
        lambda child: transform_stamped(m, "magicleap_world", child[1], x=child[0] / 8),
    )


def image(m: Message, encoding: str, width: int, height: int, step: int) -> None:
    header(m, OPTICAL)
    m.uint32("height", height)
    m.uint32("width", width)
    m.string("encoding", encoding)
    m.uint8("is_bigendian", 0)
    m.uint32("step", step)
    m.pattern_bytes("data", step * height)


def compressed_image(m: Message, length: int) -> None:
    header(m, "color_optical_frame")
    m.string("format", "rgb8; jpeg compressed bgr8")
    m.pattern_bytes("data", length)


def ffmpeg_packet(m: Message, length: int, pts: int, flags: int) -> None:
    header(m, OPTICAL)
    m.int32("width", 1016)
    m.int32("height", -1)
    m.string("encoding", "h264;yuv420p;mono8;mono8")
    m.uint64("pts", pts)
    m.uint8("flags", flags)
    m.bool("is_bigendian", flags != 0)
    m.pattern_bytes("data", length)


def compressed_video(m: Message, length: int) -> None:
    with m.nested("timestamp"):
        time(m, 1_700_000_000, 123_456_789)
    m.string("frame_id", OPTICAL)
    m.few_bytes("data", length)
    m.string("format", "h264")


def region_of_interest(m: Message, do_rectify: bool) -> None:
    m.uint32("x_offset", 16)
    m.uint32("y_offset", 8)
    m.uint32("height", 480)
    m.uint32("width", 4_294_967_295)
    m.bool("do_rectify", do_rectify)


def camera_info(m: Message, model: str, d: Sequence[float]) -> None:
    header(m, OPTICAL)
    m.uint32("height", 1016)
    m.uint32("width", 1016)
    m.string("distortion_model", model)
    m.float64_sequence("d", d)
    m.float64_array("k", [580.125, 0.0, 507.5, 0.0, 580.25, 508.5, 0.0, 0.0, 1.0])
    m.float64_array("r", [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
    m.float64_array("p", [580.125, 0.0, 507.5, 0.0, 0.0, 580.25, 508.5, 0.0, 0.0, 0.0, 1.0, 0.0])
    m.uint32("binning_x", 1)
    m.uint32("binning_y", 2)
    with m.nested("roi"):
        region_of_interest(m, do_rectify=False)


def imu(m: Message, orientation_known: bool) -> None:
    unknown = [-1.0] + [0.0] * 8
    header(m, "imu_left_frame")
    with m.nested("orientation"):
        quaternion(m, 0.0, 0.0, 0.0, 1.0)
    m.float64_array("orientation_covariance", covariance(1e-4) if orientation_known else unknown)
    with m.nested("angular_velocity"):
        xyz(m, 0.01, -0.02, 0.03)
    m.float64_array("angular_velocity_covariance", covariance(2e-4))
    with m.nested("linear_acceleration"):
        xyz(m, 0.125, -9.80665, 0.5)
    m.float64_array("linear_acceleration_covariance", covariance(3e-4))


def magnetic_field(m: Message) -> None:
    header(m, "magnetometer_left_frame")
    with m.nested("magnetic_field"):
        xyz(m, 2.1e-5, math.nan, -4.2e-5)
    m.float64_array("magnetic_field_covariance", covariance(1e-12))


def covariance(variance: float) -> list[float]:
    return [variance, 0.0, 0.0, 0.0, 2 * variance, 0.0, 0.0, 0.0, 3 * variance]


def illuminance(m: Message, value: float, variance: float) -> None:
    header(m, "light_sensor_frame")
    m.float64("illuminance", value)
    m.float64("variance", variance)


def fluid_pressure(m: Message) -> None:
    header(m, "pressure_headset_frame")
    m.float64("fluid_pressure", 101_325.0)
    m.float64("variance", 0.0)


def joy(m: Message, axes: Sequence[float], buttons: Sequence[int]) -> None:
    header(m, "controller_frame")
    m.float32_sequence("axes", axes)
    m.int32_sequence("buttons", buttons)


def detections(m: Message, ids: Sequence[str]) -> None:
    header(m, "magicleap_world")
    m.message_sequence("detections", ids, lambda id: _detection(m, id))


def _detection(m: Message, id: str) -> None:
    header(m, "magicleap_world")
    m.message_sequence("results", [id.partition(":")[2]], lambda of: _hypothesis(m, of))
    with m.nested("bbox"):
        with m.nested("center"):
            pose(m, 1.5)
        with m.nested("size"):
            xyz(m, 0.16, 0.16, 0.0)
    m.string("id", id)


def _hypothesis(m: Message, of: str) -> None:
    with m.nested("hypothesis"):
        m.string("class_id", of)
        m.float64("score", 1.0)
    with m.nested("pose"):
        pose_with_covariance(m)


def diagnostics(m: Message, values: Mapping[str, str]) -> None:
    header(m, "magicleap_map")
    m.message_sequence("status", [values], lambda it: _diagnostic_status(m, it))


def _diagnostic_status(m: Message, values: Mapping[str, str]) -> None:
    m.uint8("level", 1)
    m.string("name", "map")
    m.string("message", "no transform: localization is pending")
    m.string("hardware_id", "")
    m.message_sequence("values", list(values), lambda key: _key_value(m, key, values[key]))


def _key_value(m: Message, key: str, value: str) -> None:
    m.string("key", key)
    m.string("value", value)


def battery_state(m: Message, floats: Sequence[float], cells: Sequence[float], text: str) -> None:
    header(m, "")
    m.float32("voltage", floats[0])
    m.float32("temperature", floats[1])
    m.float32("current", floats[2])
    m.float32("charge", floats[3])
    m.float32("capacity", floats[4])
    m.float32("design_capacity", floats[5])
    m.float32("percentage", floats[6])
    m.uint8("power_supply_status", 2)
    m.uint8("power_supply_health", 1)
    m.uint8("power_supply_technology", 255)
    m.bool("present", True)
    m.float32_sequence("cell_voltage", cells)
    m.float32_sequence("cell_temperature", [10 * cell for cell in cells])
    m.string("location", text)
    m.string("serial_number", text)

"""Reads the motion of head and inertial units from a recording."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import isfinite

import numpy as np
from scipy.spatial.transform import Rotation

from ml2_receiver.errors import CalibrationError
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.stamps import header_stamp_ns

from ..bags.bag_reader import BagReader
from ..bags.decoding import decoder
from .motion import HeadPoses, Samples, UnitMotion

_POSE, _IMU = "geometry_msgs/msg/PoseStamped", "sensor_msgs/msg/Imu"
# The streams with both halves of a unit, and those with one, by the unit's frame.
_RIGID = {"imu_left": ("gyro_left", "accel_left"), "imu_right": ("gyro_right", "accel_right")}


@dataclass
class _Track:
    """Rows of numbers with stamps in ns; rows whose stamp does not rise are left out."""

    stamps_ns: list[int] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)

    def add(self, stamp_ns: int, *numbers: float) -> None:
        if not all(map(isfinite, numbers)):
            raise ValueError(f"expected finite numbers, found {numbers}")
        if not self.stamps_ns or stamp_ns > self.stamps_ns[-1]:
            self.stamps_ns.append(stamp_ns)
            self.rows.append(numbers)

    def samples(self, origin_ns: int) -> Samples:
        stamps_s = np.array([it - origin_ns for it in self.stamps_ns]) / 1e9
        return Samples(stamps_s, np.array(self.rows))


def read_motion(
    reader: BagReader, on_bytes: Callable[[int], None] = lambda _: None
) -> Mapping[str, UnitMotion]:
    """Returns the motion by unit, which are the streams of united IMUs of the headset's sides.

    Raises:
        CalibrationError: head poses or units are missing; the message says what to record.
        RecordingError: the recording is broken.
    """
    head, found = _Track(), {unit: (_Track(), _Track()) for unit in _RIGID}
    takers = _takers(reader, head, found)
    for message in reader.messages():
        if (take := takers.get(message.topic)) is not None:
            try:
                take(message.payload)
            except ValueError as error:
                raise CalibrationError(f"{message.topic}: {error}") from error
        on_bytes(len(message.payload))
    return _motions(head, found)


def _takers(
    reader: BagReader, head: _Track, found: Mapping[str, tuple[_Track, _Track]]
) -> Mapping[str, Callable[[bytes], None]]:
    """Returns what fills the tracks with the payloads of a topic, by topic."""

    def topic(stream: str) -> str:
        return load_table().streams[stream].topics[0].full_name(reader.prefix)

    takers = {topic("head_pose"): partial(_take_pose, head)}
    for unit, (gyroscope, accelerometer) in found.items():
        if topic(unit) in reader.types:
            takers[topic(unit)] = partial(_take_imu, gyroscope, accelerometer)
        else:
            of_gyroscope, of_accelerometer = _RIGID[unit]
            takers[topic(of_gyroscope)] = partial(_take_imu, gyroscope, None)
            takers[topic(of_accelerometer)] = partial(_take_imu, None, accelerometer)
    return takers


def _take_pose(head: _Track, payload: bytes) -> None:
    message = decoder(_POSE)(payload)
    p, q = message.pose.position, message.pose.orientation
    head.add(header_stamp_ns(message.header), p.x, p.y, p.z, q.x, q.y, q.z, q.w)


def _take_imu(gyroscope: _Track | None, accelerometer: _Track | None, payload: bytes) -> None:
    message = decoder(_IMU)(payload)
    w, a = message.angular_velocity, message.linear_acceleration
    for track, it in ((gyroscope, w), (accelerometer, a)):
        if track is not None:
            track.add(header_stamp_ns(message.header), it.x, it.y, it.z)


def _motions(head: _Track, found: Mapping[str, tuple[_Track, _Track]]) -> Mapping[str, UnitMotion]:
    if len(head.rows) < 2:
        raise CalibrationError(
            "expected head poses in the recording, found none",
            hint="Record with `head_pose.enabled: true`.",
        )
    units = {unit: it for unit, it in found.items() if all(len(track.rows) > 1 for track in it)}
    if not units:
        raise CalibrationError(
            f"expected accelerometer and gyroscope of {' or '.join(found)} in the recording",
            hint="Record with `other_sensors.enabled: true`. The compute pack's unit hangs on a"
            " body and is not rigid with the head: it cannot be calibrated.",
        )
    origin_ns = head.stamps_ns[0]
    poses = head.samples(origin_ns)
    try:
        rotations = Rotation.from_quat(poses.values[:, 3:])
    except ValueError as error:
        raise CalibrationError(f"head_pose: {error}") from error
    whole = HeadPoses(poses.stamps_s, poses.values[:, :3], rotations)
    return {
        unit: UnitMotion(whole, gyroscope.samples(origin_ns), accelerometer.samples(origin_ns))
        for unit, (gyroscope, accelerometer) in units.items()
    }

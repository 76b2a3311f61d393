"""Reads cameras, their poses and an IMU's rate from a recording."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ml2_receiver.topics.stamps import header_stamp_ns

from ..bags.bag_reader import BagMessage, BagReader
from ..bags.decoding import decoder
from ..errors import ExportError
from ..geometry.pose import Pose
from ..geometry.transform_tree import Tree
from ..images.image_topic import image_topic
from .kalibr import CAMERAS, Mounting, RigCamera
from .rig import Rig, calibration_of, head_in, rate_hz

_IMU, _INFO = "sensor_msgs/msg/Imu", "sensor_msgs/msg/CameraInfo"
_TF, _TF_STATIC, _TRANSFORMS = "/tf", "/tf_static", "tf2_msgs/msg/TFMessage"


@dataclass
class _Found:
    """The messages of one pass over the recording."""

    infos: dict[str, Any] = field(default_factory=dict)
    transforms: list[Any] = field(default_factory=list)
    static: list[Any] = field(default_factory=list)
    imu_ns: set[int] = field(default_factory=set)


def recorded_cameras(reader: BagReader) -> tuple[str, ...]:
    """Returns the streams of CAMERAS that have a camera_info in the recording."""
    return tuple(it for it in CAMERAS if f"{reader.prefix}/{it}/camera_info" in reader.types)


def read_rig(
    reader: BagReader, cameras: Sequence[str], imu: str | None, mounting: Mounting | None
) -> Rig:
    """Reads all of the recording.

    Args:
        cameras: stream ids; if empty, all recorded cameras of CAMERAS.
        imu: the stream id of the IMU whose rate is measured, or None.
        mounting: the IMU's in the head, or None if it is not known.

    Raises:
        ExportError: messages are missing; the error names them.
        RecordingError: the recording is broken.
    """
    cameras = cameras or recorded_cameras(reader)
    if not cameras:
        raise ExportError(f"no camera of {', '.join(CAMERAS)} is in the recording")
    found = _read(reader, cameras, imu)
    if missing := [it for it in cameras if it not in found.infos]:
        raise ExportError(f"no camera_info of {', '.join(missing)} is in the recording")
    if imu is not None and len(found.imu_ns) < 2:
        raise ExportError(f"no {reader.prefix}/{imu}/imu is in the recording")
    poses, among_cameras = _poses(found, cameras, mounting)
    topics = {it: image_topic(it, reader.prefix, reader.types.get) for it in cameras}
    rig_cameras = (
        RigCamera(topics[it].full_name(reader.prefix), calibration_of(found.infos[it]), poses[it])
        for it in cameras
    )
    return Rig(tuple(rig_cameras), rate_hz(found.imu_ns), among_cameras)


def _read(reader: BagReader, cameras: Sequence[str], imu: str | None) -> _Found:
    found = _Found()
    takers: dict[str, Callable[[BagMessage], None]] = {
        _TF: lambda it: found.transforms.append(_decoded(it, _TRANSFORMS)),
        _TF_STATIC: lambda it: found.static.append(_decoded(it, _TRANSFORMS)),
        f"{reader.prefix}/{imu}/imu": lambda it: found.imu_ns.add(
            header_stamp_ns(_decoded(it, _IMU).header)
        ),
    }

    def take_info(camera: str, message: BagMessage) -> None:
        if camera not in found.infos:
            found.infos[camera] = _decoded(message, _INFO)

    infos = {f"{reader.prefix}/{camera}/camera_info": camera for camera in cameras}
    for message in reader.messages():
        if message.topic in infos:
            take_info(infos[message.topic], message)
        elif message.topic in takers:
            takers[message.topic](message)
    return found


def _decoded(message: BagMessage, type: str) -> Any:
    try:
        return decoder(type)(message.payload)
    except ValueError as error:
        raise ExportError(f"{message.topic}: {error}") from error


def _poses(
    found: _Found, cameras: Sequence[str], mounting: Mounting | None
) -> tuple[dict[str, Pose], Mounting | None]:
    """Returns the cameras' poses at the last stamp at which all are known, and the IMU's mounting.

    A single camera needs no transform, unless an IMU is mounted beside it.
    """
    if len(cameras) == 1 and mounting is None:
        return {cameras[0]: np.eye(4)}, None
    frames = {found.infos[it].header.frame_id: it for it in cameras}
    tree = Tree.of(frames)
    instants: dict[int, dict[str, Pose]] = {}
    heads: dict[int, Pose] = {}
    try:
        for message in found.static:
            tree.stand(message)
        for message in found.transforms:
            for camera, at_ns, pose in tree.poses(message):
                instants.setdefault(at_ns, {})[camera] = pose
            heads.update(tree.heads(message))
    except ValueError as error:
        raise ExportError(f"a transform of the recording: {error}") from error
    whole = {at_ns: it for at_ns, it in instants.items() if len(it) == len(cameras)}
    if not whole:
        raise ExportError(f"no stamp has transforms of all of {', '.join(sorted(frames))}")
    last = whole[max(whole)]
    if mounting is None:
        return last, None
    first = cameras[0]
    head = head_in(whole, heads, first)
    if head is None:
        raise ExportError(f"no head poses on /tf around the images of {first}")
    return last, replace(mounting, pose=last[first] @ head @ mounting.pose)

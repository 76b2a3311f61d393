"""The poses that the 3D view shows, all in the world frame."""

import math
import threading
import time
from collections import OrderedDict
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from typing import Any

from ml2_receiver.json_text import json_text
from ml2_receiver.table.reader import load_table

from ..bags.decoding import decoder
from ..geometry.camera import camera_of
from ..geometry.lens import Lens
from ..geometry.other_frames import OtherFrames
from ..geometry.pose import Pose, pose_of
from ..geometry.transform_tree import Tree
from ..images.image_topic import camera_namespace
from ..monitoring.topic_table import Rows
from .state import known_topics, published_images

type Place = list[float] | None

SCENE = "scene"
TF, TF_STATIC, TRANSFORMS = "/tf", "/tf_static", "tf2_msgs/msg/TFMessage"
_HANDS, _GAZE, _HEAD, _MARKERS = ("hand_left", "hand_right"), "gaze", "head", "markers"
# Names of subscriptions of camera_info begin with this, and end with the stream.
_LENS = "lens "
_MOST_HZ = 15
# Data older than this are not shown.
_FRESH_S = 1.0
_KEPT_POSES = 64
# Any node may publish transforms.
_MOST_PARENTS = 300
# More than a hand has, and than the headset tracks.
_MOST_JOINTS = _MOST_MARKERS = 100
# Messages between these times are left out before they are decoded, which costs most. Transforms
# are not, since each image has its own.
_PERIOD_S, _LENS_PERIOD_S = 0.05, 0.5


class Scene:
    """The newest poses of head, cameras, hands, gaze and frames of others. Thread-safe.

    Times are in s on any clock.

    Args:
        receiver: the receiver's --name, or empty.
    """

    def __init__(self, receiver: str) -> None:
        table, prefix = load_table(), f"{receiver}/" if receiver else ""
        self._frames = {it.id: it.frame for it in table.streams.values()}
        frames = {prefix + frame: frame for frame in self._frames.values()}
        self._head = prefix + table.head_frame
        world = prefix + table.world_frame
        self._tree = Tree(frames, world, self._head)
        bodies = {prefix + it.body_frame for it in table.streams.values() if it.body_frame}
        # The names in /tf, and those in _poses.
        self._shown_as = {self._head: _HEAD, **frames}
        self._others = OtherFrames(world, {self._head, *frames, *bodies} - {world})
        self._lock = threading.Lock()
        # The poses and hands shown, by name, with the time at which they came.
        self._poses: dict[str, tuple[float, Pose]] = {}
        self._hands: dict[str, tuple[float, list[Place]]] = {}
        # The corners of an image are directions.
        self._lenses: dict[str, tuple[float, tuple[Lens, list[list[float]]]]] = {}
        self._infos: dict[str, Any] = {}
        # The sides of markers, by frame.
        self._markers: tuple[float, dict[str, float]] = 0, {}
        # The parent of each frame.
        self._parents: dict[str, tuple[float, str]] = {}
        # The poses of the optical frame of each camera by stamp in ns.
        self._at: dict[str, OrderedDict[int, Pose]] = {}
        self._due_s: dict[str, float] = {}
        self._message: tuple[int, str] = 0, ""
        self._next_s = 0.0

    def topics(self, rows: Rows, shown: Collection[str]) -> dict[str, tuple[str, str]]:
        """Returns name and type of each needed topic, by what it fills.

        Args:
            shown: the streams whose images are shown; of others, camera_info would wake the camera.
        """
        found = {it: (it, TRANSFORMS) for it in (TF, TF_STATIC)}
        for name, it in known_topics(rows).items():
            if it.stream in (*_HANDS, _GAZE, _MARKERS):
                found[it.stream] = name, it.type
        for stream, (image, _) in published_images(rows).items():
            name = f"{camera_namespace(image)}/camera_info"
            if stream in shown and name in rows:
                found[f"{_LENS}{stream}"] = name, "sensor_msgs/msg/CameraInfo"
        return found

    def take(self, filled: str, type: str, payload: bytes, at_s: float) -> None:
        """Takes the CDR of a message of the topic that fills `filled`; ignores an invalid one.

        Args:
            at_s: when the message came.
        """
        with suppress(ValueError), self._lock:
            if not self._is_due(filled, at_s):
                return
            message = decoder(type)(payload)
            if filled in (TF, TF_STATIC):
                self._take_parents(message, at_s if filled == TF else math.inf)
            if filled == TF:
                self._take_transforms(message, at_s)
                self._others.take(message, at_s + _FRESH_S)
            elif filled == TF_STATIC:
                self._others.take(message, math.inf)
                self._tree.stand(message)
            elif filled in _HANDS:
                self._hands[filled] = (
                    at_s,
                    [_place(it.position) for it in message.poses[:_MOST_JOINTS]],
                )
            elif filled == _MARKERS:
                seen = message.detections[:_MOST_MARKERS]
                self._markers = at_s, {it.id: it.bbox.size.x for it in seen}
            elif filled == _GAZE:
                self._poses[filled] = at_s, pose_of(_Transform(message.pose))
            else:
                lens = camera_of(message).lens
                self._infos[filled.removeprefix(_LENS)] = message
                self._lenses[filled.removeprefix(_LENS)] = at_s, (lens, _corners(lens))

    def forget(self) -> None:
        """Forgets what came: the next messages may be of an earlier time."""
        with self._lock:
            for newest in (
                self._poses,
                self._hands,
                self._lenses,
                self._infos,
                self._at,
                self._due_s,
            ):
                newest.clear()
            self._others.forget()
            self._markers = 0, {}

    def lens(self, stream: str) -> Lens | None:
        """Returns the lens of a camera that is shown."""
        with self._lock:
            found = self._lenses.get(stream)
            return None if found is None else found[1][0]

    def info(self, stream: str) -> Any:
        """Returns the newest CameraInfo of a camera; None before the first."""
        return self._infos.get(stream)

    def poses(self, now_s: float) -> dict[str, Pose]:
        """Returns the present pose of the head, and of each of the headset's frames, by name."""
        with self._lock:
            return dict(_since(now_s - _FRESH_S, self._poses))

    def frame_of(self, stream: str) -> str:
        """Returns the name of a camera's optical frame in poses()."""
        return self._frames[stream]

    def pose_at(self, stream: str, stamp_ns: int) -> Pose | None:
        """Returns the pose of a camera's optical frame at the stamp of a recent image."""
        with self._lock:
            poses = self._at.get(self._frames[stream])
            return None if poses is None else poses.get(stamp_ns)

    def newest(self, now_s: float) -> tuple[int, str]:
        """Returns the number of the scene, from 1, and its JSON; 15 new ones per second at most.

        Poses are matrices, column by column.
        """
        with self._lock:
            if time.monotonic() >= self._next_s:
                self._next_s = time.monotonic() + 1 / _MOST_HZ
                message = json_text(self._scene(now_s))
                if message != self._message[1]:
                    self._message = self._message[0] + 1, message
            return self._message

    def _scene(self, now_s: float) -> dict[str, Any]:
        since_s = now_s - _FRESH_S
        own = dict(_since(since_s, self._poses))
        poses = {name: _numbers(it) for name, it in own.items()}
        known = {frame: own[it] for frame, it in self._shown_as.items() if it in own}
        cameras = {
            stream: {"pose": poses[frame], "corners": corners}
            for stream, (_, corners) in _since(since_s, self._lenses)
            if (frame := self._frames[stream]) in poses
        }
        return {
            "type": SCENE,
            "head": poses.get(_HEAD),
            "gaze": poses.get(_GAZE),
            "hands": dict(_since(since_s, self._hands)),
            "markers": self._markers[1] if self._markers[0] >= since_s else {},
            "cameras": cameras,
            "parents": dict(_since(since_s, self._parents)),
            "frames": {name: _numbers(it) for name, it in self._others.poses(known, now_s).items()},
        }

    def _is_due(self, filled: str, at_s: float) -> bool:
        if filled in (TF, TF_STATIC):
            return True
        if at_s < self._due_s.get(filled, -math.inf):
            return False
        self._due_s[filled] = at_s + (_LENS_PERIOD_S if filled.startswith(_LENS) else _PERIOD_S)
        return True

    def _take_parents(self, message: Any, at_s: float) -> None:
        for it in message.transforms:
            if it.child_frame_id in self._parents or len(self._parents) < _MOST_PARENTS:
                self._parents[it.child_frame_id] = at_s, it.header.frame_id

    def _take_transforms(self, message: Any, at_s: float) -> None:
        for it in message.transforms:
            if it.child_frame_id == self._head:
                self._poses[_HEAD] = at_s, pose_of(it.transform)
        for frame, stamp_ns, pose in self._tree.poses(message):
            self._poses[frame] = at_s, pose
            poses = self._at.setdefault(frame, OrderedDict())
            poses[stamp_ns] = pose
            if len(poses) > _KEPT_POSES:
                poses.popitem(last=False)


def _since[T](since_s: float, newest: Mapping[str, tuple[float, T]]) -> Iterator[tuple[str, T]]:
    return ((name, it) for name, (then_s, it) in newest.items() if then_s >= since_s)


class _Transform:
    """A geometry_msgs/Pose under the names of geometry_msgs/Transform."""

    def __init__(self, pose: Any) -> None:
        self.translation, self.rotation = pose.position, pose.orientation


def _numbers(pose: Pose) -> list[float]:
    return [round(float(it), 4) for it in pose.T.ravel()]


def _place(position: Any) -> Place:
    place = [position.x, position.y, position.z]
    return [round(it, 4) for it in place] if all(map(math.isfinite, place)) else None


def _corners(lens: Lens) -> list[list[float]]:
    """Returns the directions of the corners of an image, without the coefficients of the lens.

    Raises:
        ValueError: they are infinite.
    """
    corners = [(0, 0), (lens.width, 0), (lens.width, lens.height), (0, lens.height)]
    found = [_direction(lens, column, row) for column, row in corners]
    if not all(math.isfinite(it) for direction in found for it in direction):
        raise ValueError(f"expected a lens with a view, found the focal length {lens.fx}")
    return found


def _direction(lens: Lens, column: int, row: int) -> list[float]:
    x, y = (column - lens.cx) / lens.fx, (row - lens.cy) / lens.fy
    radius = math.hypot(x, y)
    angle = math.atan(radius) if lens.model == "plumb_bob" else radius
    across = math.sin(angle) / radius if radius else 1.0
    return [round(it, 4) for it in (x * across, y * across, math.cos(angle))]

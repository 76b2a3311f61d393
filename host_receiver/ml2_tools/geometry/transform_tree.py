"""Computes camera poses in the world from /tf and, in the rig layout, /tf_static."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.stamps import header_stamp_ns

from .pose import Pose, pose_of

# Any node may publish static transforms; those of more frames are ignored.
_MOST_FRAMES = 1000
# The depth of a subscription to /tf_static; each node with static transforms sends a message.
STATIC_DEPTH = 100


class Tree:
    """The camera poses at the stamps of transforms, without interpolation.

    Args:
        cameras: the cameras by optical frame.
        world: the frame of all poses.
        head: the frame that the cameras of a rig are mounted on.
    """

    def __init__(self, cameras: Mapping[str, str], world: str, head: str) -> None:
        self._cameras, self._world, self._head = cameras, world, head
        self._static: dict[str, Any] = {}
        self._mounted: dict[str, Pose] = {}

    @classmethod
    def of(cls, cameras: Mapping[str, str]) -> Tree:
        """Returns the tree of the headset whose streams have these optical frames.

        A receiver with a name puts the same prefix before all of its frames.
        """
        table = load_table()
        frame, camera = next(iter(cameras.items()))
        prefix = frame.removesuffix(table.streams[camera].frame)
        return cls(cameras, prefix + table.world_frame, prefix + table.head_frame)

    def stand(self, message: Any) -> None:
        """Takes a message of /tf_static; the newest transform of each child frame counts.

        Raises:
            ValueError: a transform between the head and a camera is invalid.
        """
        for it in message.transforms:
            if it.child_frame_id in self._static or len(self._static) < _MOST_FRAMES:
                self._static[it.child_frame_id] = it
        mounted = {camera: self._mounting(frame) for frame, camera in self._cameras.items()}
        self._mounted = {camera: pose for camera, pose in mounted.items() if pose is not None}

    def _mounting(self, frame: str) -> Pose | None:
        """Returns the pose of a frame in the head, or None without static transforms to it."""
        pose, passed = np.eye(4), set[str]()
        while frame != self._head:
            step = self._static.get(frame)
            if step is None or frame in passed:
                return None
            passed.add(frame)
            pose, frame = pose_of(step.transform) @ pose, step.header.frame_id
        return pose

    def heads(self, message: Any) -> Iterator[tuple[int, Pose]]:
        """Yields stamp in ns and pose of the head for the transforms of a /tf message.

        Raises:
            ValueError: a transform is invalid.
        """
        for it in message.transforms:
            if (it.header.frame_id, it.child_frame_id) == (self._world, self._head):
                yield header_stamp_ns(it.header), pose_of(it.transform)

    def poses(self, message: Any) -> Iterator[tuple[str, int, Pose]]:
        """Yields camera, stamp in ns and pose for the transforms of a /tf message.

        Raises:
            ValueError: a transform is invalid.
        """
        for it in message.transforms:
            if it.header.frame_id != self._world:
                continue
            stamp_ns = header_stamp_ns(it.header)
            if it.child_frame_id == self._head:
                if self._mounted:
                    head = pose_of(it.transform)
                    for camera, mounting in self._mounted.items():
                        yield camera, stamp_ns, head @ mounting
            elif it.child_frame_id in self._cameras:
                camera = self._cameras[it.child_frame_id]
                # The headset has changed from the rig layout to the flat one.
                self._static.pop(it.child_frame_id, None)
                self._mounted.pop(camera, None)
                yield camera, stamp_ns, pose_of(it.transform)

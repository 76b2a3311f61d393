"""Where cameras were in the world, from /tf and, in the rig layout, /tf_static."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.stamps import header_stamp_ns

from .pose import Pose, pose_of

# Of a subscription to /tf_static, where each node that has static transforms sends a message.
STATIC_DEPTH = 100


class Tree:
    """Poses of cameras at the stamps that transforms have; nothing is interpolated.

    Args:
        cameras: by optical frame.
        world: the frame that all poses are in.
        head: the one that a rig stands on.
    """

    def __init__(self, cameras: Mapping[str, str], world: str, head: str) -> None:
        self._cameras, self._world, self._head = cameras, world, head
        self._static: dict[str, Any] = {}
        self._mounted: dict[str, Pose] = {}

    @classmethod
    def of(cls, cameras: Mapping[str, str]) -> Tree:
        """The tree of the headset whose streams have these optical frames.

        What is before a frame's own name, that of a receiver, is before all of its frames.
        """
        table = load_table()
        frame, camera = next(iter(cameras.items()))
        prefix = frame.removesuffix(table.streams[camera].frame)
        return cls(cameras, prefix + table.world_frame, prefix + table.head_frame)

    def stand(self, message: Any) -> None:
        """Takes a /tf_static; the newest transform of each child frame counts, whoever sent it.

        Raises:
            ValueError: a transform between the head and a camera is none.
        """
        self._static |= {it.child_frame_id: it for it in message.transforms}
        mounted = {camera: self._mounting(frame) for frame, camera in self._cameras.items()}
        self._mounted = {camera: pose for camera, pose in mounted.items() if pose is not None}

    def _mounting(self, frame: str) -> Pose | None:
        """The pose of a frame in the head; None when static transforms do not lead there."""
        pose, passed = np.eye(4), set[str]()
        while frame != self._head:
            step = self._static.get(frame)
            if step is None or frame in passed:
                return None
            passed.add(frame)
            pose, frame = pose_of(step.transform) @ pose, step.header.frame_id
        return pose

    def poses(self, message: Any) -> Iterator[tuple[str, int, Pose]]:
        """Cameras, stamps in ns and poses of a /tf.

        Raises:
            ValueError: a transform is none.
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
                # The headset has left the rig layout.
                self._static.pop(it.child_frame_id, None)
                self._mounted.pop(camera, None)
                yield camera, stamp_ns, pose_of(it.transform)

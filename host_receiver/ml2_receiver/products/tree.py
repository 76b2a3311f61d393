"""Where cameras were in the world, from /tf and, in the rig layout, /tf_static."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..export.pose import Pose, pose_of
from ..topics.stamps import header_stamp_ns


class Tree:
    """Poses of cameras at the stamps that transforms have; nothing is interpolated.

    Args:
        cameras: by optical frame.
        world: the frame that all poses are in.
        head: the one that a rig stands on.
    """

    def __init__(self, cameras: Mapping[str, str], world: str, head: str) -> None:
        self._cameras, self._world, self._head = cameras, world, head
        self._mounted: dict[str, Pose] = {}

    def stand(self, message: Any) -> None:
        """Takes a /tf_static, each of which has all there is.

        Raises:
            ValueError: a transform is none.
        """
        frames = {self._head: np.eye(4)}
        for it in message.transforms:
            if it.header.frame_id in frames:
                frames[it.child_frame_id] = frames[it.header.frame_id] @ pose_of(it.transform)
        self._mounted = {
            camera: frames[frame] for frame, camera in self._cameras.items() if frame in frames
        }

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
                yield self._cameras[it.child_frame_id], stamp_ns, pose_of(it.transform)

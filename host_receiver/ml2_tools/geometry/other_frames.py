"""The frames that other programs attach to the headset's: tags, robots, maps."""

import math
from collections import defaultdict
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from .pose import Pose, pose_of

# Any node may publish transforms; those of more frames are ignored.
_MOST_FRAMES = 200


class OtherFrames:
    """The newest transforms between frames that are not the headset's own. Not thread-safe.

    Args:
        world: the frame of all poses. It may have a parent, such as the map of a robot.
        own: the other frames of the headset, whose transforms are ignored.
    """

    def __init__(self, world: str, own: Collection[str]) -> None:
        self._world, self._own = world, frozenset(own)
        # By child: until when it counts, the parent, and the pose of the child in it.
        self._steps: dict[str, tuple[float, str, Pose]] = {}

    def take(self, message: Any, until_s: float) -> None:
        """Takes a tf2_msgs/TFMessage, without its invalid transforms.

        Args:
            until_s: until when its transforms count, math.inf for those of /tf_static.
        """
        for it in message.transforms:
            child = it.child_frame_id
            is_known = child in self._steps
            if child not in self._own and (is_known or len(self._steps) < _MOST_FRAMES):
                with suppress(ValueError):
                    self._steps[child] = until_s, it.header.frame_id, pose_of(it.transform)

    def forget(self) -> None:
        """Forgets what is not of /tf_static."""
        self._expire(math.inf)

    def poses(self, own: Mapping[str, Pose], now_s: float) -> dict[str, Pose]:
        """Returns the poses in the world of all frames that are attached to it.

        Args:
            own: the poses of frames of the headset, which others may be attached to.
        """
        self._expire(now_s)
        steps = defaultdict[str, list[tuple[str, Pose]]](list)
        for child, (_, parent, pose) in self._steps.items():
            steps[parent].append((child, pose))
            steps[child].append((parent, np.linalg.inv(pose)))
        found = {self._world: np.eye(4), **own}
        reached = list(found)
        for frame in reached:
            for other, pose in steps[frame]:
                if other not in found:
                    found[other] = found[frame] @ pose
                    reached.append(other)
        for frame in (self._world, *own):
            del found[frame]
        return found

    def _expire(self, now_s: float) -> None:
        for child in [it for it, (until_s, _, _) in self._steps.items() if until_s < now_s]:
            del self._steps[child]

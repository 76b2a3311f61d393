"""The received transform tree."""

from __future__ import annotations

from typing import Any

import numpy as np

from capture_stamps import nanos
from euroc import Matrix, pose_matrix
from processes import Received


def transforms(received: Received) -> dict[tuple[str, int], Matrix]:
    """Frames in the world by name and stamp in ns; nothing is said twice.

    In the rig layout those that stand on the head are wherever the head is.
    """
    tree = moving(received)
    heads = {at: pose for (child, at), pose in tree.items() if child == "head_frame"}
    for child, mounting in standing(received).items():
        tree |= {(child, at): head @ mounting for at, head in heads.items()}
    return tree


def standing(received: Received) -> dict[str, Matrix]:
    """Frames in the head by name, as the last message on /tf_static has them."""
    found = {"head_frame": np.eye(4)}
    for message in received.messages("/tf_static")[-1:] if "/tf_static" in received.topics else []:
        for it in message.transforms:
            found[it.child_frame_id] = found[it.header.frame_id] @ matrix(it.transform)
    del found["head_frame"]
    return found


def stable_since_ns(received: Received) -> int | None:
    """Since when, in the rig layout, all sensors stand on the head."""
    if "/tf_static" not in received.topics:
        return None
    return nanos(received.messages("/tf_static")[-1].transforms[0].header.stamp)


def moving(received: Received) -> dict[tuple[str, int], Matrix]:
    """What /tf says, each frame in the world."""
    found: dict[tuple[str, int], Matrix] = {}
    for message in received.messages("/tf"):
        for it in message.transforms:
            assert it.header.frame_id == "magicleap_world"
            assert (it.child_frame_id, nanos(it.header.stamp)) not in found
            found[it.child_frame_id, nanos(it.header.stamp)] = matrix(it.transform)
    return found


def matrix(transform: Any) -> Matrix:
    """Of a geometry_msgs/Transform."""
    t, r = transform.translation, transform.rotation
    return pose_matrix([t.x, t.y, t.z], r.w, r.x, r.y, r.z)

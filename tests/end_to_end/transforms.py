"""Reads the received transform tree."""

from __future__ import annotations

from typing import Any

import numpy as np

from capture_stamps import nanos
from euroc import Matrix, pose_matrix
from processes import Received


def transforms(received: Received) -> dict[tuple[str, int], Matrix]:
    """Returns the poses of all frames in the world by name and stamp in ns.

    In the rig layout, the poses of mounted frames are computed from the head's.
    """
    tree = moving(received)
    heads = {at: pose for (child, at), pose in tree.items() if child == "head_frame"}
    for child, mounting in mounted(received).items():
        tree |= {(child, at): head @ mounting for at, head in heads.items()}
    return tree


def mounted(received: Received) -> dict[str, Matrix]:
    """Returns the poses of frames in the head by name, from the last message on /tf_static."""
    found = {"head_frame": np.eye(4)}
    for message in received.messages("/tf_static")[-1:] if "/tf_static" in received.topics else []:
        for it in message.transforms:
            found[it.child_frame_id] = found[it.header.frame_id] @ matrix(it.transform)
    del found["head_frame"]
    return found


def stable_since_ns(received: Received) -> int | None:
    """Returns the stamp from which all sensors are mounted on the head; None without a rig."""
    if "/tf_static" not in received.topics:
        return None
    return nanos(received.messages("/tf_static")[-1].transforms[0].header.stamp)


def moving(received: Received) -> dict[tuple[str, int], Matrix]:
    """Returns the poses in the world on /tf by frame and stamp; asserts that none is twice."""
    found: dict[tuple[str, int], Matrix] = {}
    for message in received.messages("/tf"):
        for it in message.transforms:
            if it.child_frame_id == "magicleap_world":  # in the map
                continue
            assert it.header.frame_id == "magicleap_world"
            assert (it.child_frame_id, nanos(it.header.stamp)) not in found
            found[it.child_frame_id, nanos(it.header.stamp)] = matrix(it.transform)
    return found


def matrix(transform: Any) -> Matrix:
    """Returns a geometry_msgs/Transform as a 4x4 matrix."""
    t, r = transform.translation, transform.rotation
    return pose_matrix([t.x, t.y, t.z], r.w, r.x, r.y, r.z)

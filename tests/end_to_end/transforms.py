"""The received transform tree."""

from __future__ import annotations

from capture_stamps import nanos
from euroc import Matrix, pose_matrix
from processes import Received


def transforms(received: Received) -> dict[tuple[str, int], Matrix]:
    """Frames in the world by name and stamp in ns; nothing is said twice."""
    found: dict[tuple[str, int], Matrix] = {}
    for message in received.messages("/tf"):
        for it in message.transforms:
            assert it.header.frame_id == "magicleap_world"
            assert (it.child_frame_id, nanos(it.header.stamp)) not in found
            t, r = it.transform.translation, it.transform.rotation
            pose = pose_matrix([t.x, t.y, t.z], r.w, r.x, r.y, r.z)
            found[it.child_frame_id, nanos(it.header.stamp)] = pose
    return found

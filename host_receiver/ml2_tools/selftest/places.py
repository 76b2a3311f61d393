"""Measures what is assumed about poses of cameras, markers and maps."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from .evidence import Evidence, StreamEvidence
from .motion import poses
from .verdict import Verdict, as_assumed, unknown, within, worst

# Cameras look roughly where the head looks; other axes turn them by 90 or 180 degrees.
_MOST_DEGREES, _MOST_TILT_DEGREES = 45.0, 2.0
_MOST_MARKERS, _NEAR_S, _MOST_UNKNOWN_S = 16, 0.1, 1.0
_MAP_SWITCH = "map.enabled=false"
_NO_MARKER, _NO_MAP = "no marker was in sight", "the headset was not localized in a map"


def camera_pose_axes(fact: str, evidence: Evidence) -> Verdict:
    """World and depth cameras, whose poses have the axes of the head's, look forward, upright.

    Their pixels are not looked at.
    """
    verdicts = []
    for session in evidence.sessions:
        head = session.get("tf")
        for id in ("tf_world_center", "tf_depth"):
            camera = session.get(id)
            if head and camera and head.is_delivered and camera.is_delivered:
                verdicts.append(_turned(fact, head, camera))
    return worst(verdicts) if verdicts else unknown(fact, "no recording has poses of cameras")


def _turned(fact: str, head: StreamEvidence, camera: StreamEvidence) -> Verdict:
    head_s, rotations, _ = poses(head)
    stamps_s, cameras, _ = poses(camera)
    is_between = (stamps_s >= head_s[0]) & (stamps_s <= head_s[-1])
    if not is_between.any():
        return unknown(fact, "the head was not seen when the cameras were")
    turns = Slerp(head_s, rotations)(stamps_s[is_between]).inv() * cameras[is_between]
    degrees = float(np.degrees(np.median(turns.magnitude())))
    return within(fact, degrees, -_MOST_DEGREES, _MOST_DEGREES, "degrees off the head")


def marker_session(fact: str, evidence: Evidence) -> Verdict:
    """A marker was seen."""
    most = _most_markers(evidence)
    return as_assumed(fact, most, "markers") if most else unknown(fact, _NO_MARKER)


def marker_limit(fact: str, evidence: Evidence) -> Verdict:
    """There are never more than 16 markers at a time, and 16 if so many are in sight."""
    most = _most_markers(evidence)
    if most < _MOST_MARKERS:
        return unknown(fact, f"{most} markers were in sight, fewer than {_MOST_MARKERS}")
    return within(fact, most, 0, _MOST_MARKERS, "markers")


def _most_markers(evidence: Evidence) -> int:
    counts = [row[0] for it in evidence.all("markers") for row in it.numbers]
    return round(max(counts, default=0))


def marker_axes(fact: str, evidence: Evidence) -> Verdict:
    """The z axis of a marker that is seen points to the head's side; of an AprilTag, to the other.

    Nothing is known about x and y, since a marker may hang in any direction.
    """
    for session in evidence.sessions:
        markers, head = session.get("markers"), session.get("tf")
        if markers and head and head.is_delivered and (ahead := _ahead(markers, head)).size:
            is_turned = markers.values.get("type") == "april_tag"
            share = float((ahead < 0 if is_turned else ahead > 0).mean())
            return within(fact, share, 0.6, 1.4, "of markers turned so", "markers.type=aruco")
    return unknown(fact, _NO_MARKER)


def _ahead(markers: StreamEvidence, head: StreamEvidence) -> NDArray[np.float64]:
    """Returns the head's z in the frame of the first marker of each message, in metres."""
    head_s, _, positions = poses(head)
    seen = [(t, row[1:]) for (t, _), row in zip(markers.times_ns, markers.numbers, strict=True)]
    found = []
    for stamp_ns, pose in seen:
        place = int(np.argmin(np.abs(head_s - stamp_ns / 1e9)))
        if np.isfinite(pose).all() and abs(head_s[place] - stamp_ns / 1e9) < _NEAR_S:
            away = Rotation.from_quat(pose[3:]).inv().apply(positions[place] - pose[:3])
            found.append(away[2])
    return np.array(found)


def map_session(fact: str, evidence: Evidence) -> Verdict:
    """The headset is localized in a saved map."""
    for it in evidence.all("map"):
        if any(is_localized for _, is_localized in it.numbers):
            return as_assumed(fact, "localized")
    return unknown(fact, _NO_MAP)


def map_events(fact: str, evidence: Evidence) -> Verdict:
    """The headset says within a second whether it is localized."""
    for it in evidence.all("map"):
        stamps_s = np.array(it.times_ns, np.int64).reshape(-1, 2)[:, 0] / 1e9
        if not len(stamps_s):
            continue
        said = [at for at, (is_known, _) in zip(stamps_s, it.numbers, strict=True) if is_known]
        after_s = float((said[0] if said else stamps_s[-1]) - stamps_s[0])
        if said or after_s > _MOST_UNKNOWN_S:
            return within(fact, after_s, -_MOST_UNKNOWN_S, _MOST_UNKNOWN_S, "s", _MAP_SWITCH)
    return unknown(fact, "no recording has the state of a map")


def map_axes(fact: str, evidence: Evidence) -> Verdict:
    """The z axes of the map and of the world, which is upright, are parallel."""
    for session in evidence.sessions:
        if (world := session.get("tf_map")) and world.is_delivered:
            ups = poses(world)[1].apply([0, 0, 1])[:, 2]
            tilt = float(np.degrees(np.arccos(np.clip(np.median(ups), -1, 1))))
            tilts = -_MOST_TILT_DEGREES, _MOST_TILT_DEGREES
            return within(fact, tilt, *tilts, "degrees", _MAP_SWITCH)
    return unknown(fact, _NO_MAP)

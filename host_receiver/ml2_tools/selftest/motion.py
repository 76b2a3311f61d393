"""Measures what is assumed about clocks, inertial units, poses and trackers."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from .evidence import Evidence, StreamEvidence
from .verdict import Verdict, as_assumed, differs, unknown, within, worst

type Floats = NDArray[np.float64]

UNITS = ("left", "right", "compute_pack")
MAGNETOMETERS = ("magnetometer_left", "magnetometer_right")
_LEAST_IMU_HZ = 195.0
_MOST_DEGREES = 20.0
# In a shorter time, the head's own acceleration may not average out.
_LEAST_S = 3.5
_JOINTS, _FINGERS = 26, (range(2, 6), range(6, 11), range(11, 16), range(16, 21), range(21, 26))
_AXES = Rotation.create_group("O")
# Each opens a head tracker, and what does without one.
_HEAD_TRACKED = {
    "tf": "",
    "gaze": "gaze.backend=openxr",
    "hand_left": "hands.backend=openxr",
    "hand_right": "hands.backend=openxr",
    "controller": "controller.backend=openxr",
}


def android_clocks(fact: str, evidence: Evidence) -> Verdict:
    """Samples of Android's sensors arrive soon after their stamps."""
    ids = (*(f"accel_{it}" for it in UNITS), *MAGNETOMETERS)
    return _soon(fact, evidence, ids)


def mltime(fact: str, evidence: Evidence) -> Verdict:
    """Poses of the vendor's library arrive soon after their stamps."""
    return _soon(fact, evidence, ("head_pose",))


def _soon(fact: str, evidence: Evidence, ids: tuple[str, ...]) -> Verdict:
    # Slower samples waited for this machine, or for the link.
    found = [evidence.needed(it) for it in ids]
    return worst([within(fact, float(np.min(it.latencies_ms)), -5, 100, "ms") for it in found])


def magnetometer_calibrated(fact: str, evidence: Evidence) -> Verdict:
    """The field is as long as that of the Earth."""
    found = [evidence.needed(it) for it in MAGNETOMETERS]
    lengths = [float(np.median(np.linalg.norm(it.numbers, axis=1))) * 1e6 for it in found]
    return worst([within(fact, it, 25, 65, "uT") for it in lengths])


def inertial_rate_and_axes(fact: str, evidence: Evidence) -> Verdict:
    """Units are fast, feel gravity, and turn with the head about axes parallel to its own."""
    for unit in UNITS:
        accelerometer = evidence.needed(f"accel_{unit}")
        if accelerometer.fastest_hz < _LEAST_IMU_HZ:
            return differs(fact, accelerometer.fastest_hz, "Hz")
    verdicts = [_axes(fact, evidence, unit) for unit in UNITS[:2]]
    unjudged = [it for it in verdicts if it.verdict == "unknown"]
    return unjudged[0] if unjudged else worst(verdicts)


def _axes(fact: str, evidence: Evidence, unit: str) -> Verdict:
    gyro, accel = evidence.needed(f"gyro_{unit}"), evidence.needed(f"accel_{unit}")
    beside = next(it for it in evidence.sessions if it.get(f"gyro_{unit}") is gyro)
    head = beside.get("tf")
    if head is None or not head.is_delivered:
        return unknown(fact, "no recording has poses of the head beside the inertial units")
    stamps_s, rotations, _ = poses(head)
    if len(stamps_s) < 2 or stamps_s[-1] - stamps_s[0] < _LEAST_S:
        return unknown(fact, f"the head was seen for less than {_LEAST_S} s")
    turns = (rotations[:-1].inv() * rotations[1:]).as_rotvec() / np.diff(stamps_s)[:, None]
    middles_s = (stamps_s[1:] + stamps_s[:-1]) / 2
    felt = _interpolated(gyro, middles_s, slice(0, 3))
    if np.linalg.svd(turns, compute_uv=False)[1] < 0.1 * np.sqrt(len(turns)):
        return unknown(fact, "the head did not turn about two axes")
    mount, _ = Rotation.align_vectors(turns, felt)
    off = np.degrees(np.min((_AXES.inv() * mount).magnitude()))
    axes = within(fact, float(off), -_MOST_DEGREES, _MOST_DEGREES, "degrees")
    forces = _interpolated(accel, stamps_s, slice(3, 6))
    upwards = (rotations * mount).apply(forces).mean(axis=0)
    return worst([axes, within(fact, float(upwards[2]), 9.3, 10.3, "m/s^2 upwards")])


def _interpolated(stream: StreamEvidence, at_s: Floats, columns: slice) -> Floats:
    stamps_s, numbers = _rising(stream)
    return np.stack([np.interp(at_s, stamps_s, it) for it in numbers[:, columns].T], axis=1)


def _rising(stream: StreamEvidence) -> tuple[Floats, Floats]:
    """Returns stamps in s, each once, and the numbers at them."""
    stamps_ns, places = np.unique(np.array(stream.times_ns)[:, 0], return_index=True)
    return stamps_ns / 1e9, np.array(stream.numbers)[places]


def poses(stream: StreamEvidence) -> tuple[Floats, Rotation, Floats]:
    """Returns stamps in s, rotations and positions of finite poses."""
    stamps_s, numbers = _rising(stream)
    is_whole = np.isfinite(numbers).all(axis=1)
    numbers = numbers[is_whole]
    return stamps_s[is_whole], Rotation.from_quat(numbers[:, 3:]), numbers[:, :3]


def openxr_local_space(fact: str, evidence: Evidence) -> Verdict:
    """The head of OpenXR is where the vendor's library, which makes /tf, has it."""
    for session in evidence.sessions:
        openxr, sdk = session.get("head_pose"), session.get("tf")
        if openxr and sdk and openxr.values.get("backend") == "openxr" and sdk.is_delivered:
            return _offset(fact, openxr, sdk)
    return unknown(fact, "no recording has head_pose of openxr beside /tf")


def _offset(fact: str, openxr: StreamEvidence, sdk: StreamEvidence) -> Verdict:
    sdk_s, sdk_rotations, sdk_positions = poses(sdk)
    stamps_s, rotations, positions = poses(openxr)
    both = (stamps_s >= sdk_s[0]) & (stamps_s <= sdk_s[-1])
    there = np.stack([np.interp(stamps_s[both], sdk_s, it) for it in sdk_positions.T], axis=1)
    metres = np.linalg.norm(positions[both] - there, axis=1)
    turned = (Slerp(sdk_s, sdk_rotations)(stamps_s[both]).inv() * rotations[both]).magnitude()
    switch = "head_pose.backend=sdk"
    return worst(
        [
            within(fact, float(np.median(metres)) * 1e3, -5, 5, "mm", switch),
            within(fact, float(np.degrees(np.median(turned))), -0.5, 0.5, "degrees", switch),
        ]
    )


def tracker_layouts(fact: str, evidence: Evidence) -> Verdict:
    """Poses of eyes and hands have unit quaternions."""
    verdicts = []
    for id, switch in (
        ("gaze", "gaze.backend=openxr"),
        ("hand_left", "hands.backend=openxr"),
        ("hand_right", "hands.backend=openxr"),
    ):
        if (found := evidence.find(id, backend="sdk")) is not None:
            verdicts.append(_layout(fact, found, switch))
    return worst(verdicts)


def _layout(fact: str, stream: StreamEvidence, switch: str) -> Verdict:
    poses = np.array(stream.numbers).reshape(-1, 7)
    poses = poses[np.isfinite(poses).all(axis=1)]
    if not len(poses):
        return unknown(fact, "nothing was tracked")
    length = float(np.median(np.linalg.norm(poses[:, 3:], axis=1)))
    return within(fact, length, 1 - 1e-3, 1 + 1e-3, "length of quaternions", switch)


def trackers_need_head(fact: str, evidence: Evidence) -> Verdict:
    """Several head trackers are open at once: that of the transform tree, and those of others."""
    for session in evidence.sessions:
        tracked = {id: session[id] for id in _HEAD_TRACKED if id in session}
        sdk = {id: it for id, it in tracked.items() if it.values.get("backend", "sdk") == "sdk"}
        if any(it.is_delivered for it in sdk.values()):
            for id, it in sdk.items():
                for reason in it.reasons:
                    if reason.startswith("MLHeadTrackingCreate: "):
                        return differs(fact, f"{id}: {reason}", switch=_HEAD_TRACKED[id])
    if (gaze := evidence.find("gaze", backend="sdk")) is None:
        return unknown(fact, evidence.why_missing("gaze", backend="sdk"))
    return as_assumed(fact, gaze.rate_hz, "Hz")


def hand_key_points(fact: str, evidence: Evidence) -> Verdict:
    """Neighbouring joints of a finger are as far apart as bones are long."""
    switch, lengths_cm = "hands.backend=openxr", []
    for id in ("hand_left", "hand_right"):
        if (found := evidence.find(id, backend="sdk")) is None:
            continue
        joints = np.array(found.numbers).reshape(-1, _JOINTS, 7)[:, :, :3]
        joints = joints[np.isfinite(joints).all(axis=(1, 2))]
        for finger in _FINGERS if len(joints) else ():
            for near, far in pairwise(finger):
                bone = np.linalg.norm(joints[:, far] - joints[:, near], axis=1)
                lengths_cm.append(float(np.median(bone)) * 100)
    if not lengths_cm:
        return unknown(fact, "no hand was seen")
    return worst([within(fact, it, 1, 12, "cm", switch) for it in lengths_cm])


def controller_layout(fact: str, evidence: Evidence) -> Verdict:
    """The controller has unit quaternions, and values in their ranges."""
    pose = evidence.needed("controller", backend="sdk")
    joy = evidence.needed("controller_joy", backend="sdk")
    switch = "controller.backend=openxr"
    largest = float(np.max(np.abs(joy.numbers)))
    values = within(fact, largest, -1 - 1e-3, 1 + 1e-3, "at most", switch)
    return worst([_layout(fact, pose, switch), values])


def controller_paths(fact: str, evidence: Evidence) -> Verdict:
    """Every button, the trigger and the touchpad change."""
    joy = evidence.needed("controller_joy", backend="openxr")
    names = ("trigger", "touch x", "touch y", "force", "bumper", "menu", "touch")
    still = np.ptp(np.array(joy.numbers), axis=0) == 0
    if not still.any():
        return as_assumed(fact, len(names), "values change")
    return unknown(fact, f"nobody used {', '.join(np.array(names)[still])}")

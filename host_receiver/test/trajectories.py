"""Trajectories made up for tests."""

import cv2
import numpy as np

from ml2_tools.evaluation.trajectory import Trajectory
from ml2_tools.geometry.pose import Pose

START_NS = 1_700_000_000_123_456_789


def wandering(rate_hz: float = 30, duration_s: float = 6, shift_s: float = 0) -> Trajectory:
    """Some metres through all directions; `shift_s` later along the way at the same stamps."""
    times_s = np.arange(0, duration_s, 1 / rate_hz)
    return [(START_NS + round(at_s * 1e9), _pose(at_s + shift_s)) for at_s in times_s]


def moved(trajectory: Trajectory, scale: float, vector: tuple[float, ...]) -> Trajectory:
    """Returns the trajectory of an estimator that knows neither the world nor its scale."""
    turn = np.asarray(cv2.Rodrigues(np.array(vector))[0], np.float64)
    return [(at, _similar(pose, scale, turn)) for at, pose in trajectory]


def _pose(at_s: float) -> Pose:
    pose = np.eye(4)
    pose[:3, :3] = cv2.Rodrigues(np.array([0.2, 0.5 * at_s, 0.3 * np.sin(at_s)]))[0]
    pose[:3, 3] = np.sin(0.9 * at_s), np.cos(0.7 * at_s), 0.4 * np.sin(1.3 * at_s)
    return pose


def _similar(pose: Pose, scale: float, turn: Pose) -> Pose:
    similar = np.eye(4)
    similar[:3, :3] = turn @ pose[:3, :3]
    similar[:3, 3] = scale * turn @ pose[:3, 3] + (4, 5, 6)
    return similar

"""A drawn motion of a head, and what poses and an inertial unit on it show, from formulas alone."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ml2_tools.calibration.motion import HeadPoses, Samples, UnitMotion

type Floats = NDArray[np.float64]

_POSE_HZ, _IMU_HZ = 60.0, 250.0
# White noise and walks of TUM-VI's unit (its calibration for OpenVINS), in SI units and sqrt(Hz).
_FORCE_NOISE, _FORCE_WALK, _TURN_NOISE, _TURN_WALK = 2.8e-3, 8.6e-4, 1.6e-4, 2.2e-5
_JITTER_M, _JITTER_RAD = 0.5e-3, np.radians(0.05)
_GRAVITY = np.array([0.0, 0.0, -9.80665])


@dataclass(frozen=True)
class TrueMount:
    """The true mount of a unit, drawn at random; units as of Estimate."""

    rotation: Rotation
    translation_m: Floats
    time_offset_s: float


class HeadMotion:
    """Sums of sines for each axis.

    Args:
        turning: shares of the turns about front-back, left-right and up-down.
    """

    def __init__(self, seed: int, turning: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> None:
        self._random = random = np.random.default_rng(seed)
        shares = np.array(turning)[:, None]
        self._turns = random.uniform(0.1, 0.35, (3, 4)) * shares, random.uniform(0.15, 0.9, (3, 4))
        self._moves = random.uniform(0.02, 0.1, (3, 4)), random.uniform(0.1, 0.9, (3, 4))
        self._phases = random.uniform(0, 2 * np.pi, (2, 3, 4))
        self.mount = TrueMount(
            Rotation.random(rng=random), random.uniform(-0.1, 0.1, 3), random.uniform(-0.02, 0.02)
        )

    def rotations(self, at_s: Floats) -> Rotation:
        angles = self._summed(self._turns, self._phases[0], at_s)
        return Rotation.from_euler("ZYX", angles[:, ::-1])

    def positions(self, at_s: Floats) -> Floats:
        return self._summed(self._moves, self._phases[1], at_s)

    def _summed(self, sines: tuple[Floats, Floats], phases: Floats, at_s: Floats) -> Floats:
        amplitudes, frequencies_hz = sines
        return np.asarray(
            (amplitudes * np.sin(2 * np.pi * frequencies_hz * at_s[:, None, None] + phases)).sum(2)
        )

    def observed(self, duration_s: float, delay_s: float = 0.0) -> UnitMotion:
        """Returns noisy observations.

        Args:
            delay_s: by how much the poses are late, as a filter on the headset would make them.
        """
        poses_s, unit_s = (np.arange(0, duration_s, 1 / it) for it in (_POSE_HZ, _IMU_HZ))
        jitter = Rotation.from_rotvec(self._noise(_JITTER_RAD, len(poses_s)))
        poses = HeadPoses(
            poses_s,
            self.positions(poses_s - delay_s) + self._noise(_JITTER_M, len(poses_s)),
            self.rotations(poses_s - delay_s) * jitter,
        )
        at_s, inverse = unit_s - self.mount.time_offset_s, self.mount.rotation.inv()
        turns = inverse.apply(self._rates(at_s))
        forces = inverse.apply(
            self.rotations(at_s).inv().apply(self._acceleration(at_s) - _GRAVITY)
        )
        return UnitMotion(
            poses,
            Samples(unit_s, turns + self._errors(0.005, _TURN_NOISE, _TURN_WALK, len(unit_s))),
            Samples(unit_s, forces + self._errors(0.05, _FORCE_NOISE, _FORCE_WALK, len(unit_s))),
        )

    def _noise(self, sigma: float, count: int) -> Floats:
        return self._random.normal(0, sigma, (count, 3))

    def _errors(self, bias: float, noise: float, walk: float, count: int) -> Floats:
        steps = self._noise(walk / np.sqrt(_IMU_HZ), count)
        white = self._noise(noise * np.sqrt(_IMU_HZ), count)
        return self._noise(bias, 1) + white + np.cumsum(steps, axis=0)

    def _rates(self, at_s: Floats, step_s: float = 1e-4) -> Floats:
        turned = self.rotations(at_s - step_s).inv() * self.rotations(at_s + step_s)
        return np.asarray(turned.as_rotvec() / (2 * step_s))

    def _acceleration(self, at_s: Floats, step_s: float = 1e-3) -> Floats:
        """Returns the acceleration of the unit, in the world."""
        before, now, after = (
            self.positions(it) + self.rotations(it).apply(self.mount.translation_m)
            for it in (at_s - step_s, at_s, at_s + step_s)
        )
        return np.asarray((before - 2 * now + after) / step_s**2)

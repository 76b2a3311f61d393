"""Estimates how an inertial unit is mounted on the head, from the poses of the head and its data.

Both see one motion. The turns of the head between two poses are those that the gyroscope sums up.
The acceleration of the unit's position, as a weighted mean over 0.6 s, is what the accelerometer
feels, less gravity. The weights are cubic B-splines: by partial integration, their second
derivatives take the place of derivatives of the measured positions, whose noise would drown them.

The unknowns are fitted together by least squares with a Cauchy loss. Residuals of neighbouring
times are correlated, so the covariance is inflated by the peak of their spectrum (Bartlett 1950).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, CubicSpline
from scipy.optimize import least_squares
from scipy.signal import correlate, fftconvolve
from scipy.spatial.transform import Rotation, RotationSpline

from ml2_receiver.errors import CalibrationError

from .motion import Floats, HeadPoses, Samples, UnitMotion

# Standard gravity (CGPM 1901), in m/s^2. On the ground it differs by up to 0.03 from it.
_GRAVITY, _GRAVITY_SIGMA = 9.80665, 0.02
_STEP_S = 0.005
_TURN_STEPS = 64  # a power of two
# The distance of the knots of the weights, and of the centres of two neighbouring means.
_KNOT_S, _CENTRE_S = 0.15, 0.1
_LARGEST_OFFSET_S = 0.2
_LEAST_S = 20.0
# Times between samples that are further apart are not used.
_LONGEST_GAP_S = 0.1
# Maximum standard deviations of an accepted calibration.
_LARGEST_SIGMA_M, _LARGEST_SIGMA_RAD = 0.005, np.radians(0.1)
# Axes about which the head turned less than this share of the axis with most.
_LEAST_SHARE = 0.4
# Steps of each fit: a motion that shows little leads nowhere.
_FITS, _MOST_STEPS = 3, 20
# Scales of the residuals: turns in rad, accelerations in m/s^2. Interpolation costs the least.
_FIRST_SCALES, _LEAST_SCALES = np.array([1e-3, 0.05]), np.array([1e-5, 1e-3])
_OUTLIER_SIGMAS = 5.0
# Residuals that are further apart are taken for independent.
_LAGS = 16
# The median of the absolute values of normal numbers, as a share of their standard deviation.
_MEDIAN_SHARE = 0.6745
_TURNS = {
    0: "tilt the head to left and right (about front-back)",
    1: "nod (about left-right)",
    2: "shake the head (about up-down)",
}


@dataclass(frozen=True)
class Estimate:
    """The mount of a unit, with standard deviations.

    Attributes:
        rotation: from the unit's axes to the head's.
        translation_m: the unit's position in the head's axes.
        time_offset_s: what to add to the stamps of the poses for those of the unit.
        gyroscope_bias: rad/s, in the unit's axes, as is `accelerometer_bias`, in m/s^2.
        gravity: the acceleration of free fall in the world's axes, m/s^2.
        rotation_sigma_rad: about each of the head's axes.
        turn_rates: the root mean square of the head's turn rate about each of its axes, rad/s.
    """

    rotation: Rotation
    translation_m: Floats
    time_offset_s: float
    gyroscope_bias: Floats
    accelerometer_bias: Floats
    gravity: Floats
    rotation_sigma_rad: Floats
    translation_sigma_m: Floats
    time_offset_sigma_s: float
    turn_rates: Floats
    duration_s: float


def estimate_mount(motion: UnitMotion) -> Estimate:
    """Returns how the unit is mounted.

    Raises:
        CalibrationError: there is too little data or motion; the message says what to do.
    """
    problem = _Problem(motion.poses, motion.gyroscope, motion.accelerometer)
    found, covariance = problem.solve()
    sigma = np.sqrt(np.diag(covariance))
    estimate = Estimate(
        rotation=Rotation.from_rotvec(found[:3]) * problem.rotation,
        translation_m=found[3:6],
        time_offset_s=float(found[6]),
        gyroscope_bias=found[7:10],
        accelerometer_bias=found[10:13],
        gravity=found[13:16],
        rotation_sigma_rad=sigma[:3],
        translation_sigma_m=sigma[3:6],
        time_offset_sigma_s=float(sigma[6]),
        turn_rates=problem.turn_rates,
        duration_s=problem.duration_s,
    )
    _check_motion(estimate)
    return estimate


def _check_motion(estimate: Estimate) -> None:
    worst_m = float(estimate.translation_sigma_m.max())
    worst_rad = float(estimate.rotation_sigma_rad.max())
    if worst_m <= _LARGEST_SIGMA_M and worst_rad <= _LARGEST_SIGMA_RAD:
        return
    rates = estimate.turn_rates
    missing = [it for axis, it in _TURNS.items() if rates[axis] < _LEAST_SHARE * rates.max()]
    asked = f"{' and '.join(missing)} too" if missing else "turn faster, about all axes"
    raise CalibrationError(
        "the motion does not show how the unit is mounted: its position would be known to"
        f" {min(1e3 * worst_m, 9999):.0f} mm and its rotation to"
        f" {min(np.degrees(worst_rad), 180):.2g} degrees; wanted are"
        f" {1e3 * _LARGEST_SIGMA_M:.0f} mm and {np.degrees(_LARGEST_SIGMA_RAD):.1f} degrees",
        hint=f"Record again, and {asked}.",
    )


class _Problem:
    """The residuals of one recording, on a grid of _STEP_S.

    The unknowns are a correction of `rotation` (3), the unit's position (3), the time offset, the
    biases of gyroscope (3) and accelerometer (3), and gravity (3).
    """

    def __init__(self, poses: HeadPoses, gyroscope: Samples, accelerometer: Samples) -> None:
        tracks = poses.stamps_s, gyroscope.stamps_s, accelerometer.stamps_s
        begin_s = max(it[0] for it in tracks) + 2 * _LARGEST_OFFSET_S
        end_s = max(begin_s, min(it[-1] for it in tracks) - 2 * _LARGEST_OFFSET_S)
        self._at_s = np.arange(begin_s, end_s, _STEP_S)
        is_known = ~np.logical_or.reduce([_is_in_gap(self._at_s, it) for it in tracks])
        self.duration_s = float(is_known.sum() * _STEP_S)
        if self.duration_s < _LEAST_S:
            raise CalibrationError(
                "expected head poses, gyroscope and accelerometer together, without gaps, for"
                f" {_LEAST_S:.0f} s or more, found {self.duration_s:.1f} s",
                hint="Record a minute of motion, with few other streams.",
            )
        self._turns = CubicSpline(gyroscope.stamps_s, gyroscope.values)
        self._forces = CubicSpline(accelerometer.stamps_s, accelerometer.values)
        spline = RotationSpline(poses.stamps_s, poses.rotations)
        self._head = spline(self._at_s)
        self._positions = CubicSpline(poses.stamps_s, poses.positions_m)(self._at_s)
        rates = spline(self._at_s, 1)
        self.turn_rates: Floats = np.sqrt(np.mean(rates**2, axis=0))
        self._matrices = self._head.as_matrix()
        steps = np.arange(0, len(self._at_s) - _TURN_STEPS, _TURN_STEPS)
        steps = steps[[bool(is_known[it : it + _TURN_STEPS + 1].all()) for it in steps]]
        self._turned = self._head[steps].inv() * self._head[steps + _TURN_STEPS]
        middles = steps[:, None] + np.arange(_TURN_STEPS)
        self._middles_s = self._at_s[middles.ravel()] + _STEP_S / 2
        self._weights, self._curvatures = _weights()
        self._is_mean_known = self._means(1.0 * ~is_known[:, None], self._weights)[:, 0] < 1e-9
        self._accelerations = self._means(self._positions, self._curvatures)
        self._of_lever = self._means(self._matrices.reshape(-1, 9), self._curvatures)
        self._offset_s = self._first_offset(rates)
        unit = self._turns(self._at_s + self._offset_s)
        self.rotation, _ = Rotation.align_vectors(rates - rates.mean(0), unit - unit.mean(0))

    def _first_offset(self, rates: Floats) -> float:
        """Returns the shift at which head and unit turn equally fast, whatever the rotation."""
        head = np.linalg.norm(rates, axis=1)
        unit = np.linalg.norm(self._turns(self._at_s), axis=1)
        most = round(_LARGEST_OFFSET_S / _STEP_S)
        match = correlate(unit - unit.mean(), head - head.mean(), "full", "fft")
        middle = len(head) - 1
        return float(_STEP_S * (np.argmax(match[middle - most : middle + most + 1]) - most))

    def _means(self, values: Floats, weights: Floats) -> Floats:
        """Returns the weighted means of columns, one row for each centre."""
        every = round(_CENTRE_S / _STEP_S)
        return np.asarray(fftconvolve(values, weights[:, None], "valid", axes=0)[::every])

    def solve(self) -> tuple[Floats, Floats]:
        """Returns the unknowns and their covariance."""
        found = np.zeros(16)
        found[6], found[15] = self._offset_s, -_GRAVITY
        scales = _FIRST_SCALES
        for _ in range(_FITS):
            fit = least_squares(
                lambda it, scales=scales: self._whitened(it, scales),
                found,
                x_scale=[0.01] * 3 + [0.1] * 3 + [0.01] + [0.01] * 3 + [0.1] * 6,
                loss="cauchy",
                f_scale=3.0,
                ftol=1e-6,
                max_nfev=_MOST_STEPS,
            )
            found = fit.x
            scales = np.maximum(_LEAST_SCALES, [_sigma(it) for it in self._residuals(found)])
        inflation = [_inflation(it) for it in self._residuals(found)]
        return found, _covariance(self._jacobian(found, scales * np.sqrt(inflation)))

    def _whitened(self, unknowns: Floats, scales: Floats) -> Floats:
        prior = (np.linalg.norm(unknowns[13:16]) - _GRAVITY) / _GRAVITY_SIGMA
        groups = zip(self._residuals(unknowns), scales, strict=True)
        return np.concatenate([*((it / scale).ravel() for it, scale in groups), [prior]])

    def _jacobian(self, at: Floats, scales: Floats) -> Floats:
        step = 1e-5
        changes = step * np.eye(len(at))
        pairs = [
            (self._whitened(at + it, scales), self._whitened(at - it, scales)) for it in changes
        ]
        return np.stack([(after - before) / (2 * step) for after, before in pairs], axis=1)

    def _residuals(self, unknowns: Floats) -> tuple[Floats, Floats]:
        """Returns the rotation vectors of each turn in rad, and the mean accelerations, n x 3."""
        rotation = Rotation.from_rotvec(unknowns[:3]) * self.rotation
        lever, offset_s, of_gyroscope = unknowns[3:6], unknowns[6], unknowns[7:10]
        of_accelerometer, gravity = unknowns[10:13], unknowns[13:16]

        rates = self._turns(self._middles_s + offset_s) - of_gyroscope
        summed = Rotation.from_rotvec(rates * _STEP_S)
        while len(summed) > len(self._turned):
            summed = summed[::2] * summed[1::2]
        turns = ((rotation * summed * rotation.inv()).inv() * self._turned).as_rotvec()

        forces = rotation.apply(self._forces(self._at_s + offset_s) - of_accelerometer)
        felt = self._means(np.einsum("nij,nj->ni", self._matrices, forces), self._weights)
        moved = self._accelerations + self._of_lever.reshape(-1, 3, 3) @ lever
        return turns, (moved - felt - gravity)[self._is_mean_known]


def _is_in_gap(at_s: Floats, stamps_s: Floats) -> NDArray[np.bool_]:
    """Returns which times have no sample on one of their sides within _LONGEST_GAP_S."""
    after = np.clip(np.searchsorted(stamps_s, at_s), 1, len(stamps_s) - 1)
    return np.asarray(stamps_s[after] - stamps_s[after - 1] > _LONGEST_GAP_S)


def _weights() -> tuple[Floats, Floats]:
    """Returns the weights of a mean on the grid, whose sum is 1, and their second derivatives."""
    spline = BSpline.basis_element(_KNOT_S * np.arange(-2, 3), extrapolate=False)
    at_s = np.arange(-2 * _KNOT_S + _STEP_S, 2 * _KNOT_S - _STEP_S / 2, _STEP_S)
    weights = spline(at_s) * _STEP_S / _KNOT_S
    curvatures = spline.derivative(2)(at_s) * _STEP_S / _KNOT_S
    return np.asarray(weights), np.asarray(curvatures)


def _sigma(residuals: Floats) -> float:
    """Returns the standard deviation without regard to outliers."""
    return float(np.median(np.abs(residuals)) / _MEDIAN_SHARE)


def _inflation(residuals: Floats) -> float:
    """Returns by how much the residuals vary more than on average, at the frequency with most.

    Which frequencies the motion has decides how the residuals' correlation acts on an unknown: this
    is the worst case. It is the greatest value of the spectrum by Bartlett (1950), whose mean is 1.
    """
    limit = _OUTLIER_SIGMAS * _sigma(residuals)
    limited = np.clip(residuals, -limit, limit)
    limited = limited - limited.mean(0)
    shares = [(limited[lag:] * limited[: len(limited) - lag]).sum() for lag in range(_LAGS)]
    window = 1 - np.arange(_LAGS) / _LAGS
    spectrum = 2 * np.fft.rfft(window * np.array(shares) / shares[0], 16 * _LAGS).real - 1
    return float(spectrum.max())


def _covariance(jacobian: Floats) -> Floats:
    """Returns the inverse of the normal matrix; unknowns that nothing shows get a huge one."""
    lengths = np.linalg.norm(jacobian, axis=0)
    lengths[lengths == 0] = 1.0
    _, singular, directions = np.linalg.svd(jacobian / lengths, full_matrices=False)
    scaled = directions.T / np.maximum(singular, 1e-9) / lengths[:, None]
    return np.asarray(scaled @ scaled.T)

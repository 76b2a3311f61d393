"""The noise of the simulated headset, as independent programs measure it."""

from itertools import pairwise
from pathlib import Path

import allantools
import numpy as np
import pytest
from numpy.typing import NDArray

from imu_calibration import smoothed_error_s
from noisy_headset import IMU_HZ, Floats, NoisyHeadset
from processes import ROOT

_STILL = ROOT / "native" / "tests" / "still_head.tum"
_HOUR_S = 3600.0
# The noise of the BMI160 of TUM-VI, as OpenVINS's configuration for the data set has them:
# white noise in unit/sqrt(Hz), walk in unit/s/sqrt(Hz).
_FORCE, _TURN = (2.8e-3, 8.6e-4), (1.6e-4, 2.2e-5)
# At these the white noise and the walk are at least nine tenths of the deviation.
_WHITE_S, _WALK_S = 0.1, 40.0
# Grey levels, and pixels.
_READ, _PATCH = 2, 256


def test_an_hour_has_the_densities_of_noise_and_walk() -> None:
    _, values = NoisyHeadset(_STILL).inertial("imu_left", _HOUR_S)
    for columns, (white, walk) in ((values[:, :3], _FORCE), (values[:, 3:], _TURN)):
        short, long = np.sqrt(np.mean([_deviations(it) ** 2 for it in columns.T], axis=0))
        assert short * np.sqrt(_WHITE_S) == pytest.approx(white, rel=0.05)
        assert long / np.sqrt(_WALK_S / 3) == pytest.approx(walk, rel=0.2)


def test_a_mean_of_poses_is_as_late_as_it_is_old() -> None:
    assert smoothed_error_s(seed=1) < 0.5e-3


def test_the_variance_of_pixels_grows_with_signal_and_gain(tmp_path: Path) -> None:
    """EMVA 1288: (gain * read noise)^2 + gain * levels per electron * value, and the rounding."""
    path = _turning(tmp_path, rad_per_s=0)
    times_s = (2.0, 7.4)  # in much light, and in little
    exact = NoisyHeadset(path, noise=0, image_noise=0)
    expected = [exact.world_center(it) for it in times_s]
    noisy = NoisyHeadset(path, image_noise=_READ)
    found = [noisy.world_center(it) for it in times_s]
    gains = [max(1, 300 / _measured_lux(noisy, it)) for it in times_s]
    assert gains[0] == 1
    assert gains[1] > 1.4
    for gain, truth, picture in zip(gains, expected, found, strict=True):
        brightness = np.sum(truth * picture) / np.sum(truth**2)
        values, errors = brightness * truth, picture - brightness * truth
        edges = np.linspace(30, 200, 18)
        bins = [(values >= low) & (values < high) for low, high in pairwise(edges)]
        variances = [errors[it].var() for it in bins]
        weights = [
            np.sqrt(it.sum()) / variance for it, variance in zip(bins, variances, strict=True)
        ]
        slope, offset = np.polyfit([values[it].mean() for it in bins], variances, 1, w=weights)
        assert slope == pytest.approx(gain * 255 / 10_000, rel=0.05)
        assert offset == pytest.approx((gain * _READ) ** 2 + (1 + brightness**2) / 12, rel=0.1)


def test_a_turning_camera_blurs_along_the_way_of_the_image(tmp_path: Path) -> None:
    """The way has f * |turn rate| * exposure pixels; its transform is a sinc."""
    path = _turning(tmp_path, rad_per_s=2)
    exact, at_s = NoisyHeadset(path, noise=0, image_noise=0), 4.0
    sharp = _spectrum(exact.world_center(at_s))
    noisy = NoisyHeadset(path, image_noise=0)
    blurred = _spectrum(noisy.world_center(at_s))
    exposure_s = 5e-3 * min(1, 300 / _measured_lux(noisy, at_s))
    # The camera looks down by 5 degrees, so its image turns a little, too.
    expected_px = 582.0 * np.cos(np.radians(5)) * 2 * exposure_s
    assert 3 < expected_px < 8

    def error(length_px: float) -> float:
        model = sharp * np.sinc(length_px * np.fft.fftfreq(_PATCH))
        scale = np.vdot(model, blurred) / np.vdot(model, model)
        return float(np.sum(np.abs(blurred - scale * model) ** 2))

    lengths_px = np.arange(0, 3 * expected_px, 0.05)
    found_px = lengths_px[np.argmin([error(it) for it in lengths_px])]
    assert found_px == pytest.approx(expected_px, rel=0.1)


def _turning(folder: Path, rad_per_s: float) -> Path:
    """Returns the path of a head that turns to the left."""
    times_s = np.arange(0, 12, 0.01)
    half = rad_per_s * times_s / 2
    zero = np.zeros_like(times_s)
    rows = np.column_stack([times_s, zero, zero, zero, zero, zero, np.sin(half), np.cos(half)])
    np.savetxt(folder / "turning.tum", rows, fmt="%.12f")
    return folder / "turning.tum"


def _measured_lux(headset: NoisyHeadset, at_s: float) -> float:
    """Returns the light as automatic exposure sees it: a first-order lag of 0.3 s, by steps."""
    step_s = 1e-3
    times_s = at_s + np.arange(-4, 0, step_s)
    lux = headset.light(times_s)
    measured = lux[0]
    for it in lux:
        measured += (it - measured) * step_s / 0.3
    return float(measured)


def _spectrum(picture: Floats) -> NDArray[np.complex128]:
    """Returns the transform of the middle, where the image moves across."""
    first = (len(picture) - _PATCH) // 2
    window = np.hanning(_PATCH)[:, None] * np.hanning(_PATCH)
    middle = picture[first : first + _PATCH, first : first + _PATCH]
    return np.fft.fft2((middle - middle.mean()) * window)


def _deviations(values: Floats) -> Floats:
    """Returns the Allan deviations for both times, by IEEE 952's definition."""
    times_s = [_WHITE_S, _WALK_S]
    _, deviations, _, _ = allantools.oadev(values, IMU_HZ, data_type="freq", taus=times_s)
    return np.asarray(deviations)

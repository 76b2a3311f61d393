"""Measures what is assumed about cameras."""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.json_body import Scalar

from ..geometry.lens import Lens, rays, z_per_distance
from .evidence import Evidence, StreamEvidence
from .verdict import Verdict, as_assumed, unknown, within, worst

type Floats = NDArray[np.float64]

WORLD = ("world_left", "world_center", "world_right")
EYES = ("eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right")
_RATE, _GAP, _BRIGHTNESS = 0.03, 0.2, 0.05
_LEAST_RATIO = 1.3
# Large enough that a wrong kind of distance bends a wall by more than the noise.
_PATCH_PX, _STEP_PX, _PATCHES = 96, 4, 5
_LEAST_CORRELATION, _LEAST_RANGE = 0.3, 1.5
_LEAST_SEEN, _FLAT_M, _LEAST_FLATTER = 0.95, 0.005, 3.0
_NO_PICTURES = "no recording has other images than video of world_left"


def _rate(fact: str, stream: StreamEvidence, expected_hz: float, switch: str = "") -> Verdict:
    least, most = expected_hz * (1 - _RATE), expected_hz * (1 + _RATE)
    if stream.rate_hz < least <= stream.highest_hz:
        return unknown(
            fact, f"images were left out: {stream.rate_hz:.1f} Hz of {expected_hz:.0f} came"
        )
    return within(fact, stream.fastest_hz, least, most, "Hz", switch)


def _expected_hz(stream: StreamEvidence) -> float:
    return float(stream.values["update_rate"])


def camera_rates(fact: str, evidence: Evidence) -> Verdict:
    """World and eye cameras deliver at the rate of their mode, by the device's stamps."""
    found = [evidence.needed(id, backend="sdk") for id in (*WORLD, *EYES)]
    return worst([_rate(fact, it, _expected_hz(it)) for it in found])


def depth_rates(fact: str, evidence: Evidence) -> Verdict:
    """The depth camera delivers at the rate that the headset has applied."""
    found = evidence.needed("depth", backend="sdk")
    modes = load_table().sections["depth_center"].modes
    known = {rate for mode in modes for rate in mode.rates}
    alike = [it for it in known if abs(it / found.fastest_hz - 1) < _RATE]
    switch = f"depth_center.update_rate={alike[0]}" if alike else ""
    return _rate(fact, found, _expected_hz(found), switch)


def jpeg_encoder(fact: str, evidence: Evidence) -> Verdict:
    """No image of the RGB camera is left out since the encoder is busy."""
    found = evidence.needed("color", format="jpeg")
    return _rate(fact, found, _expected_hz(found), "picture_center.format=h264")


def video_encoders(fact: str, evidence: Evidence) -> Verdict:
    """Four encoders run at once, each at the rate of its camera."""
    for session in evidence.sessions:
        found = [session[id] for id in (*WORLD, "color") if id in session]
        found = [it for it in found if it.values.get("format") == "h264" and it.is_delivered]
        if len(found) == len(WORLD) + 1:
            switch = "world_center.format=jpeg"
            return worst([_rate(fact, it, _expected_hz(it), switch) for it in found])
    return unknown(fact, "no recording has video of the world cameras and RGB together")


def frame_number_gaps(fact: str, evidence: Evidence) -> Verdict:
    """The stamps of two images are as many periods apart as their frame numbers."""
    return worst([_gaps(fact, it) for it in _cameras(evidence)])


def _gaps(fact: str, stream: StreamEvidence) -> Verdict:
    stamps_ns, numbers = np.diff(np.array(stream.frames, np.int64), axis=0).T
    neighbours = stamps_ns[numbers == 1]
    is_normal = len(neighbours) > len(stamps_ns) / 10
    period_ns = np.percentile(neighbours, 10) if is_normal else 1e9 / _expected_hz(stream)
    # A frame that was never made has no number, and lengthens some intervals.
    periods = np.percentile(stamps_ns / (np.maximum(numbers, 1) * period_ns), 10)
    return within(fact, float(periods), 1 - _GAP, 1 + _GAP, "periods")


def _cameras(evidence: Evidence) -> Iterator[StreamEvidence]:
    for id in (*WORLD, "depth", "color", *EYES):
        yield from (it for it in evidence.all(id) if len(it.frames) > 1 and it.is_delivered)


def cameras_together(fact: str, evidence: Evidence) -> Verdict:
    """All nine cameras deliver in one session."""
    ids = (*WORLD, *EYES, "color", "depth")
    for session in evidence.sessions:
        if all(id in session and session[id].is_delivered for id in ids):
            return as_assumed(fact, len(ids), "cameras")
    return unknown(fact, "no recording has all cameras")


def normal_exposure_stream(fact: str, evidence: Evidence) -> Verdict:
    """Stream 0 of a world camera is brighter than stream 1."""
    normal, low = (_grey(evidence, stream=it) for it in (0, 1))
    if low is None:
        why = evidence.why_missing("world_left", stream=1)
        return unknown(fact, f"{why}; stream 1 comes while a controller is tracked")
    if normal is None:
        return unknown(fact, _NO_PICTURES)
    ratio = float(normal[0] / max(low[0], 1e-6))
    margin = math.log(max(ratio, 1e-6)) / math.log(_LEAST_RATIO)
    if margin > 1:
        return as_assumed(fact, ratio, "times as bright")
    if margin < -1:
        switch = "world_left.stream=1"
        return Verdict(fact, "differs", ratio, "times as bright", switch, -margin)
    return unknown(fact, f"both streams are equally bright: {ratio:.2f}")


def _grey(evidence: Evidence, **values: Scalar) -> Floats | None:
    """Returns mean and standard deviation of the pixels of world_left; video has none."""
    found = (it.greys for it in evidence.all("world_left", **values) if it.greys)
    return next((np.median(it, axis=0) for it in found), None)


def openxr_pixel_sensor(fact: str, evidence: Evidence) -> Verdict:
    """Both backends show pictures of equal brightness and contrast."""
    sdk, openxr = (_grey(evidence, backend=it, stream=0) for it in ("sdk", "openxr"))
    if sdk is None or openxr is None:
        return unknown(fact, _NO_PICTURES)
    ratios = openxr / np.maximum(sdk, 1e-6)
    limits = 1 - _BRIGHTNESS, 1 + _BRIGHTNESS
    switch = "world_center.backend=sdk"
    return worst([within(fact, float(it), *limits, "of the sdk's", switch) for it in ratios])


def depth_is_radial(fact: str, evidence: Evidence) -> Verdict:
    """Walls in depth images are flat where z was made of the distances, as the code does it.

    If the vendor's values were z already, they would be flat before that.
    """
    found = evidence.needed("depth", backend="sdk", radial=False)
    if found.lens is None or not found.depths:
        return unknown(fact, "no recording has depth with camera_info")
    per_distance = z_per_distance(found.lens)
    depths = found.depths.values()
    as_z = [it for depth in depths for it in _bends(depth / per_distance, found.lens)]
    as_radial = [it for depth in depths for it in _bends(depth, found.lens)]
    if len(as_z) < _PATCHES:
        return unknown(fact, "no wall is in view")
    bend_z, bend_radial = (float(np.mean(sorted(it)[:_PATCHES])) for it in (as_z, as_radial))
    if min(bend_z, bend_radial) > _FLAT_M:
        return unknown(fact, "no wall is in view")
    flatter = bend_z / bend_radial
    margin = math.log(flatter) / math.log(_LEAST_FLATTER)
    if margin > 1:
        return as_assumed(fact, flatter, "times as flat")
    if margin < -1:
        switch = "depth_center.radial=true"
        return Verdict(fact, "differs", flatter, "times as flat", switch, -margin)
    return unknown(fact, "no wall in view shows a difference")


def depth_confidence(fact: str, evidence: Evidence) -> Verdict:
    """Near surfaces, from which more light comes back, have the larger confidence."""
    found = evidence.needed("depth", backend="sdk", confidence=True)
    stamps_ns = [*found.confidences]
    if not stamps_ns:
        return unknown(fact, "no depth image came with its confidence")
    depths = np.concatenate([found.depths[it].ravel() for it in stamps_ns])
    confidences = np.concatenate([found.confidences[it].ravel() for it in stamps_ns])
    is_seen = np.isfinite(depths) & np.isfinite(confidences)
    near, far = np.percentile(depths[is_seen], (10, 90))
    if far < _LEAST_RANGE * near:
        return unknown(fact, f"all surfaces in view are {near:.2f} to {far:.2f} m away")
    if np.ptp(confidences[is_seen]) == 0:
        return unknown(fact, "it is the same everywhere")
    correlation = float(spearmanr(depths[is_seen], confidences[is_seen])[0])
    margin, unit = correlation / _LEAST_CORRELATION, "correlation with distance"
    if margin < -1:
        return as_assumed(fact, correlation, unit)
    if margin > 1:
        return Verdict(fact, "differs", correlation, unit, margin=margin)
    return unknown(fact, f"it has little to do with distance: {correlation:.2f}")


def _bends(depth: NDArray[np.floating], lens: Lens) -> Iterator[float]:
    """Yields by how much, in metres, each part of a depth image misses a plane."""
    x, y = rays(lens)
    for row in range(0, depth.shape[0] - _PATCH_PX + 1, _PATCH_PX // 4):
        for column in range(0, depth.shape[1] - _PATCH_PX + 1, _PATCH_PX // 4):
            rows = slice(row, row + _PATCH_PX, _STEP_PX)
            patch = rows, slice(column, column + _PATCH_PX, _STEP_PX)
            z = depth[patch].ravel()
            is_seen = np.isfinite(z)
            if is_seen.mean() >= _LEAST_SEEN:
                # The inverse depth of a plane is linear in x and y of the rays.
                inverse = 1 / z[is_seen]
                plane = np.stack([x[patch].ravel(), y[patch].ravel(), np.ones_like(z)], axis=1)
                plane = plane[is_seen]
                factors = np.linalg.lstsq(plane, inverse, rcond=None)[0]
                yield float(np.std((inverse - plane @ factors) / inverse**2))

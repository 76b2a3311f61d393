"""Judges facts of config/facts.yaml. Each judgement is a pure function of recorded data."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ml2_receiver.wire.json_body import Scalar

from . import cameras, motion, places
from .evidence import Evidence
from .verdict import Verdict, as_assumed, differs, unknown

type Need = tuple[str, Mapping[str, Scalar]]
type Measure = Callable[[str, Evidence], Verdict]

_SDK, _OPENXR = {"backend": "sdk"}, {"backend": "openxr"}
_UNITS = tuple(f"{kind}_{unit}" for kind in ("accel", "gyro") for unit in motion.UNITS)


# A line of native/sdk/dump.h, and what stands behind a struct if nothing is written there.
_DUMP = re.compile(
    r"dump (?P<name>\w+) (?P<offset>\d+) of (?P<size>\d+): (?P<hex>(?:[\da-f]{2})+)$"
)
_PATTERN = 0xA5
_STRUCTS = {
    "MLWorldCameraData": "world_center.backend=openxr",
    "MLDepthCameraData": "depth_center.backend=openxr",
    "MLEyeCameraData": "eye_nasal_left.backend=openxr",
    "MLEyeTrackingStateEx": "gaze.backend=openxr",
    "MLHandTrackingData": "hands.backend=openxr",
    "MLControllerSystemStateEx": "controller.backend=openxr",
    "MLInputControllerStateEx": "controller.backend=openxr",
}


def _need(*ids: str, **values: Scalar) -> tuple[Need, ...]:
    return tuple((id, values) for id in ids)


@dataclass(frozen=True)
class _Claim:
    """The judgement of one fact.

    Attributes:
        refuted_by: matches the reason of a stream that does not run since the fact does not hold.
        needs: the streams that have to deliver, with the values that they need.
        measure: the judgement of their data; None if it is enough that they run.
        switch: KEY=VALUE with which a headset that refuted the fact can go on.
    """

    refuted_by: str = ""
    needs: tuple[Need, ...] = ()
    measure: Measure | None = None
    switch: str = ""


_CLAIMS: Mapping[str, _Claim] = {
    "android_clocks": _Claim(
        "expected timestamps within a second",
        _need(*(f"accel_{it}" for it in motion.UNITS), *motion.MAGNETOMETERS),
        motion.android_clocks,
    ),
    "normal_exposure_stream": _Claim(
        needs=_need("world_left", stream=0, **_SDK), measure=cameras.normal_exposure_stream
    ),
    "null_buffers": _Claim(
        "depth (flags|confidence)",
        _need("depth", confidence=False, flags=False, **_SDK),
        switch="depth_center.flags=true",
    ),
    "depth_rates": _Claim(needs=_need("depth", **_SDK), measure=cameras.depth_rates),
    "picture_stride": _Claim(
        "^(?!.*depth (flags|confidence)).*(with stride|bytes per pixel|pixel stride)",
        _need("world_left", "depth", "eye_nasal_left", **_SDK),
    ),
    "frame_number_gaps": _Claim(
        needs=_need("world_left", "depth", **_SDK), measure=cameras.frame_number_gaps
    ),
    "perception_system_first": _Claim(
        "MLPerceptionStartup: |PerceptionSystemNotStarted",
        _need("world_left", "depth", "eye_nasal_left", **_SDK),
    ),
    "snapshot_threads": _Claim(
        r"MLPerception\w*Snapshot: ", _need("head_pose", "gaze", **_SDK) + _need("color")
    ),
    "cameras_together": _Claim(
        r"ML(Depth|World|Eye)Camera\w+: ",
        measure=cameras.cameras_together,
        switch="picture_center.enabled=false",
    ),
    "camera_rates": _Claim(
        needs=_need(*cameras.WORLD, *cameras.EYES, **_SDK), measure=cameras.camera_rates
    ),
    "sensor_names": _Claim(
        "lists no single",
        _need(*_UNITS, *motion.MAGNETOMETERS),
    ),
    "inertial_rate_and_axes": _Claim(needs=_need(*_UNITS), measure=motion.inertial_rate_and_axes),
    "magnetometer_calibrated": _Claim(
        needs=_need(*motion.MAGNETOMETERS), measure=motion.magnetometer_calibrated
    ),
    "jpeg_encoder": _Claim(
        "failed to encode a JPEG",
        _need("color", format="jpeg"),
        cameras.jpeg_encoder,
        "picture_center.format=h264",
    ),
    "video_encoders": _Claim(
        "no encoder for h264|encoder .* does not",
        measure=cameras.video_encoders,
        switch="world_center.format=jpeg",
    ),
    "openxr_pixel_sensor": _Claim(
        r"/pixelsensor/.*configured|PixelSensor\w*: ",
        _need("world_left", stream=0, **_SDK) + _need("world_left", "depth", **_OPENXR),
        cameras.openxr_pixel_sensor,
        "world_center.backend=sdk",
    ),
    "openxr_local_space": _Claim(
        needs=_need("head_pose", **_OPENXR), measure=motion.openxr_local_space
    ),
    "openxr_loader": _Claim(
        "xrInitializeLoaderKHR|xrCreateInstance|libopenxr",
        _need("world_left", **_OPENXR),
        switch="world_center.backend=sdk",
    ),
    "tracker_layouts": _Claim(
        r"ML(Eye|Hand)Tracking\w*: ",
        _need("gaze", "hand_left", **_SDK),
        motion.tracker_layouts,
        "gaze.backend=openxr",
    ),
    "trackers_need_head": _Claim(measure=motion.trackers_need_head),
    "hand_key_points": _Claim(needs=_need("hand_left", **_SDK), measure=motion.hand_key_points),
    "controller_layout": _Claim(
        r"ML(Controller|Input)\w*: ",
        _need("controller", "controller_joy", **_SDK),
        motion.controller_layout,
        "controller.backend=openxr",
    ),
    "controller_library": _Claim(
        r"not available: libinput\.magicleap\.so \(",
        _need("controller_joy", **_SDK),
        switch="controller.backend=openxr",
    ),
    "controller_paths": _Claim(
        "^controller.*: xrSuggestInteractionProfileBindings",
        _need("controller_joy", **_OPENXR),
        motion.controller_paths,
        "controller.backend=sdk",
    ),
    "mltime": _Claim(r"MLTimeConvert\w+: ", _need("head_pose", **_SDK), motion.mltime),
    "color_camera_ids": _Claim(
        "lists no camera", _need("color", camera_id=1), switch="picture_center.camera_id=0"
    ),
    "vendor_symbols": _Claim(
        r"not available: lib(perception\.magicleap|input\.magicleap\.so/)",
        _need("world_left", "depth", "eye_nasal_left", "head_pose", "gaze", **_SDK)
        + _need("hand_left", "controller", "controller_joy", **_SDK),
    ),
    "camera_pose_axes": _Claim(measure=places.camera_pose_axes),
    "marker_session": _Claim(
        r"^markers: (xr\w*Marker|not available: (markers|XR_ML_marker))",
        measure=places.marker_session,
        switch="markers.enabled=false",
    ),
    "marker_axes": _Claim(measure=places.marker_axes),
    "marker_limit": _Claim(measure=places.marker_limit),
    "map_session": _Claim(
        r"^map: (xr\w*Locali|xrCreateReferenceSpace|not available: XR_ML_locali)",
        measure=places.map_session,
        switch="map.enabled=false",
    ),
    "map_events": _Claim(measure=places.map_events),
    "map_axes": _Claim(measure=places.map_axes),
    "depth_confidence": _Claim(
        needs=_need("depth", confidence=True, **_SDK), measure=cameras.depth_confidence
    ),
    "depth_is_radial": _Claim(
        needs=_need("depth", radial=False, **_SDK), measure=cameras.depth_is_radial
    ),
}


def _refused_pose_instant(fact: str, evidence: Evidence) -> Verdict:
    if evidence.log is None:
        return unknown(fact, "the device's log was not read")
    refused = sum("MLPerceptionGetPredictedSnapshot" in it for it in evidence.log)
    return differs(fact, refused, "lines") if refused else as_assumed(fact, 0, "lines")


def _vendor_structs(fact: str, evidence: Evidence) -> Verdict:
    written = dict.fromkeys(_STRUCTS, 0)
    seen = set()
    for line in evidence.log or ():
        if (dump := _DUMP.search(line)) and dump["name"] in _STRUCTS:
            seen.add(dump["name"])
            room = bytes.fromhex(dump["hex"])[max(0, int(dump["size"]) - int(dump["offset"])) :]
            written[dump["name"]] += len(room) - room.count(_PATTERN)
    most = max(written, key=lambda it: written[it])
    if written[most]:
        return differs(fact, f"{written[most]} bytes behind {most}", "", _STRUCTS[most])
    if missing := [it for it in _STRUCTS if it not in seen]:
        return unknown(fact, f"the log has no dump of {missing[0]}")
    return as_assumed(fact, len(seen), "structs")


def _openxr_permission(fact: str, evidence: Evidence) -> Verdict:
    for session in evidence.sessions:
        for it in session.values():
            if it.denied and it.values.get("backend") == "openxr":
                return as_assumed(fact, it.reasons[-1])
    return unknown(fact, "no permission was missing")


def _keystore_tls(fact: str, evidence: Evidence) -> Verdict:
    if evidence.is_encrypted:
        return as_assumed(fact, "a paired session")
    return unknown(fact, "no session was paired")


def _adb(fact: str, evidence: Evidence) -> Verdict:
    if evidence.is_behind_adb:
        return as_assumed(fact, "the app was started, and its log read")
    return unknown(fact, "no headset was behind adb")


_OTHERS: Mapping[str, Measure] = {
    "vendor_structs": _vendor_structs,
    "refused_pose_instant": _refused_pose_instant,
    "openxr_permission": _openxr_permission,
    "keystore_tls": _keystore_tls,
    "adb": _adb,
}


def judge(evidence: Evidence) -> list[Verdict]:
    """Returns a verdict for each fact that recordings can tell."""
    return [judge_fact(it, evidence) for it in (*_CLAIMS, *_OTHERS)]


def judge_fact(fact: str, evidence: Evidence) -> Verdict:
    """Returns the verdict on one of these facts."""
    if (measure := _OTHERS.get(fact)) is not None:
        return measure(fact, evidence)
    claim = _CLAIMS[fact]
    if claim.refuted_by and (found := evidence.first_reason(re.compile(claim.refuted_by))):
        return differs(fact, ": ".join(found), switch=claim.switch)
    for id, values in claim.needs:
        if evidence.find(id, **values) is None:
            return unknown(fact, evidence.why_missing(id, **values))
    if claim.measure is not None:
        return claim.measure(fact, evidence)
    return as_assumed(fact, ", ".join(dict.fromkeys(id for id, _ in claim.needs)))

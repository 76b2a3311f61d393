"""Judgements of recorded data: each fact, as assumed and otherwise, on data that are made here."""

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from ml2_receiver.table.reader import load_table
from ml2_tools.geometry.lens import Lens, rays, z_per_distance
from ml2_tools.selftest.cameras import EYES, WORLD
from ml2_tools.selftest.evidence import Evidence, StreamEvidence
from ml2_tools.selftest.judge import judge
from ml2_tools.selftest.motion import MAGNETOMETERS, UNITS
from ml2_tools.selftest.verdict import Verdict, as_objects

FACTS: Mapping[str, Any] = yaml.safe_load(
    (Path(__file__).parents[2] / "config/facts.yaml").read_text("utf-8")
)
SECONDS, GRAVITY, LATE_NS = 4, 9.81, 4_000_000
JOINTS = 26
LENS = Lens(544, 480, 354.5, 342.8, 270.7, 241.2, "plumb_bob", (0.0, 0.0, 0.0, 0.0, 0.0))

type Sessions = list[dict[str, StreamEvidence]]


def stamps(rate_hz: float) -> list[tuple[int, int]]:
    """The stamps of a stream, and when they were received."""
    at_ns = [round(it * 1e9 / rate_hz) for it in range(round(SECONDS * rate_hz))]
    return [(it, it + LATE_NS) for it in at_ns]


def camera(rate_hz: float = 30, grey: float = 100, **values: Any) -> StreamEvidence:
    values = {"backend": "sdk", "stream": 0, "update_rate": round(rate_hz), **values}
    times_ns = stamps(rate_hz)
    frames = [(stamp, 1000 + number) for number, (stamp, _) in enumerate(times_ns)]
    return StreamEvidence(values, times_ns=times_ns, frames=frames, greys=[(grey, grey / 2)] * 3)


def head_at(seconds: Any) -> Rotation:
    """The head nods and shakes."""
    nod, shake = 0.3 * np.sin(3 * seconds), 0.4 * np.sin(2 * seconds)
    return Rotation.from_euler("zy", np.stack([shake, nod], axis=-1))


def readings(rate_hz: float, values_at: Callable[[float], Any], **values: Any) -> StreamEvidence:
    times_ns = stamps(rate_hz)
    numbers = [tuple(map(float, values_at(stamp / 1e9))) for stamp, _ in times_ns]
    return StreamEvidence(values, times_ns=times_ns, numbers=numbers)


def turn_at(seconds: float) -> Any:
    step = 1e-4
    return (head_at(seconds - step).inv() * head_at(seconds + step)).as_rotvec() / (2 * step)


def up_at(seconds: float) -> Any:
    return head_at(seconds).inv().apply([0, 0, GRAVITY])


def head_pose(**values: Any) -> StreamEvidence:
    return readings(60, lambda it: (it / 10, 0, 1.7, *head_at(it).as_quat()), **values)


def hand(**values: Any) -> StreamEvidence:
    """A hand whose joints lie 3 cm apart, in the order of OpenXR."""
    joints = [(0.03 * it, 0, 0, 0, 0, 0, 1) for it in range(JOINTS)]
    return readings(60, lambda _: np.ravel(joints), **values)


def joy(**values: Any) -> StreamEvidence:
    return readings(60, lambda it: (*[math.sin(it)] * 4, *[float(math.sin(it) > 0)] * 3), **values)


def markers(count: int = 16, *, kind: str = "aruco") -> StreamEvidence:
    """Markers on a wall before the head, with the axes of aruco_opencv."""
    right, up, out = (0, -1, 0), (0, 0, 1), (-1, 0, 0)
    pose = Rotation.from_matrix(np.transpose([right, up, out])).as_quat()
    return readings(30, lambda _: (count, 3, 0, 1.5, *pose), type=kind)


def localization(known_after_s: float = 0) -> StreamEvidence:
    return readings(2, lambda it: (it >= known_after_s, it >= known_after_s))


def map_of_world(tilt_degrees: float = 0) -> StreamEvidence:
    tilt = Rotation.from_euler("x", tilt_degrees, degrees=True).as_quat()
    return readings(30, lambda _: (1, 2, 0, *tilt))


def backward() -> StreamEvidence:
    """A camera whose poses are those of an optical frame."""
    turn = Rotation.from_euler("xy", [90, 90], degrees=True)
    return readings(60, lambda it: (0, 0, 1.7, *(head_at(it) * turn).as_quat()))


def wall(*, is_z: bool = True) -> Any:
    """The depth of a wall that is seen aslant, or values as the code makes them of z."""
    x, _ = rays(LENS)
    z = 2 / (1 + 0.2 * x)
    noise = np.random.default_rng(1).normal(0, 1e-3, z.shape)
    return ((z if is_z else z * z_per_distance(LENS)) + noise).astype(np.float32)


def confident(confidence_at: Callable[[Any], Any], far_m: float = 2) -> StreamEvidence:
    """A depth camera that sees a floor, with the confidence at these distances."""
    it = camera(radial=False, confidence=True, flags=False)
    z = np.tile(np.linspace(0.9, far_m, 480, dtype=np.float32)[:, None], (1, 544))
    it.lens, it.depths, it.confidences = LENS, {0: z}, {0: confidence_at(z)}
    return it


def sound() -> Sessions:
    """Four sessions with a headset that is as assumed; a test may replace what is in them."""
    return [{id: replace(it) for id, it in session.items()} for session in _sound()]


@functools.cache
def _sound() -> Sessions:
    sdk: dict[str, Any] = {"backend": "sdk"}
    openxr: dict[str, Any] = {"backend": "openxr"}
    everything = {id: camera() for id in (*WORLD, *EYES)}
    everything["color"] = camera(15, backend="camera2", format="jpeg", camera_id=1)
    everything["depth"] = camera(radial=False, confidence=False, flags=False)
    everything["depth"].lens, everything["depth"].depths = LENS, {0: wall()}
    for unit in UNITS:
        everything[f"gyro_{unit}"] = readings(210, lambda it: (*turn_at(it), 0, 0, 0))
        everything[f"accel_{unit}"] = readings(210, lambda it: (0, 0, 0, *up_at(it)))
    for id in MAGNETOMETERS:
        everything[id] = readings(50, lambda _: (2e-5, 0, -4e-5))
    everything["tf"] = head_pose()
    everything["tf_world_center"] = head_pose()
    everything["head_pose"] = head_pose(**sdk)
    everything["gaze"] = head_pose(**sdk)
    everything |= {"hand_left": hand(**sdk), "hand_right": hand(**sdk)}
    everything |= {"controller": head_pose(**sdk), "controller_joy": joy(**sdk)}
    video = {id: camera(format="h264") for id in (*WORLD, "color")}
    video["gaze"] = head_pose(**sdk)
    low = {"world_left": camera(grey=20, stream=1), "depth": confident(lambda z: 100 / z**2)}
    other = {"world_left": camera(**openxr), "depth": camera(**openxr)}
    other |= {"head_pose": head_pose(**openxr), "tf": head_pose()}
    other |= {"controller_joy": joy(**openxr)}
    other |= {"markers": markers(), "map": localization(), "tf_map": map_of_world()}
    return [everything, video, low, other]


def dumped(name: str, beyond: int = 0) -> list[str]:
    """The lines of the device's log with a struct of 40 bytes and the 64 behind it."""
    bytes_of = bytes(40) + bytes(beyond) + b"\xa5" * (64 - beyond)
    return [
        f"11-28 10:00:00.000 I/ml2s (99): dump {name} {it} of 40: {bytes_of[it : it + 32].hex()}"
        for it in range(0, len(bytes_of), 32)
    ]


STRUCTS = {
    "MLWorldCameraData": "world_center",
    "MLDepthCameraData": "depth_center",
    "MLEyeCameraData": "eye_nasal_left",
    "MLEyeTrackingStateEx": "gaze",
    "MLHandTrackingData": "hands",
    "MLControllerSystemStateEx": "controller",
    "MLInputControllerStateEx": "controller",
}
DUMPS = [line for it in STRUCTS for line in dumped(it)]


def evidence_of(sessions: Sessions) -> Evidence:
    denied = StreamEvidence({"backend": "openxr"}, ["no permission for /pixelsensor/x"], True)
    all_sessions = [*sessions, {"eye_nasal_left": denied}]
    return Evidence(all_sessions, log=DUMPS, is_encrypted=True, is_behind_adb=True)


def fails(session: int, id: str, reason: str) -> Callable[[Sessions], None]:
    def fail(sessions: Sessions) -> None:
        values = sessions[session][id].values
        sessions[session][id] = StreamEvidence(values, [reason])

    return fail


def becomes(session: int, id: str, make: Callable[[], StreamEvidence]) -> Callable[..., None]:
    def put(sessions: Sessions) -> None:
        sessions[session][id] = make()

    return put


def skipping() -> StreamEvidence:
    """A camera whose frame numbers count twice as fast as its frames come."""
    it = camera()
    it.frames = [(stamp, 2 * number) for stamp, number in it.frames]
    return it


def bowl() -> StreamEvidence:
    it = camera(radial=False, confidence=False, flags=False)
    it.lens, it.depths = LENS, {0: wall(is_z=False)}
    return it


def late(it: StreamEvidence, by_s: float) -> StreamEvidence:
    it.times_ns = [(stamp - round(by_s * 1e9), received) for stamp, received in it.times_ns]
    return it


def dark_stream_0(sessions: Sessions) -> None:
    sessions[0]["world_left"].greys, sessions[3]["world_left"].greys = [(5, 3)] * 3, [(5, 3)] * 3


def away(metres: float) -> StreamEvidence:
    return readings(
        60,
        lambda it: (it / 10 + metres, 0, 1.7, *head_at(it).as_quat()),
        backend="openxr",
    )


MLTIME = "MLTimeConvertSystemTimeToMLTime: UnspecifiedFailure (4)"
STRIDE = "world camera: 1016x1016 pixels with stride 5 do not fit 1040384 bytes"
NAMES = "this headset lists no single Headset Left Accelerometer sensor; it lists: IMU"
ENCODER = "no encoder for h264 takes 1016x1016 at 30 Hz and 8 Mbit/s; this headset has: none"
PROFILE = "xrSuggestInteractionProfileBindings"
SYMBOL = "not available: libperception.magicleap.so/MLEyeTrackingGetStateEx"
LIBRARY = "not available: libinput.magicleap.so (not found)"
# Headsets that differ in one fact each, and what the verdict says was found.
OTHERWISE: Mapping[str, tuple[Callable[[Sessions], None], Any]] = {
    "android_clocks": (
        becomes(0, "magnetometer_left", lambda: late(readings(50, lambda _: (0, 0, 4e-5)), 2)),
        pytest.approx(2004),
    ),
    "normal_exposure_stream": (dark_stream_0, pytest.approx(0.25)),
    "null_buffers": (fails(0, "depth", "depth flags: 544x480 pixels with stride 0"), "depth flags"),
    "depth_rates": (
        becomes(0, "depth", lambda: camera(25, update_rate=30, confidence=False, flags=False)),
        pytest.approx(25),
    ),
    "picture_stride": (fails(0, "world_left", STRIDE), "stride 5"),
    "frame_number_gaps": (becomes(0, "eye_nasal_left", skipping), pytest.approx(0.5)),
    "perception_system_first": (
        fails(0, "eye_nasal_left", "MLPerceptionStartup: UnspecifiedFailure (4)"),
        "MLPerceptionStartup",
    ),
    "snapshot_threads": (
        fails(0, "gaze", "MLPerceptionGetSnapshot: UnspecifiedFailure (4)"),
        "MLPerceptionGetSnapshot",
    ),
    "cameras_together": (
        fails(0, "eye_temple_left", "MLEyeCameraConnect: UnspecifiedFailure (4)"),
        "MLEyeCameraConnect",
    ),
    "camera_rates": (becomes(0, "world_right", lambda: camera(20, update_rate=30)), 20),
    "sensor_names": (fails(0, "accel_left", NAMES), "it lists: IMU"),
    "inertial_rate_and_axes": (
        becomes(0, "gyro_left", lambda: readings(210, lambda it: (*tilted(turn_at(it)), 0, 0, 0))),
        pytest.approx(45, abs=1),
    ),
    "magnetometer_calibrated": (
        becomes(0, "magnetometer_right", lambda: readings(50, lambda _: (0, 0, 400e-6))),
        pytest.approx(400),
    ),
    "jpeg_encoder": (
        becomes(0, "color", lambda: camera(7, update_rate=15, format="jpeg", camera_id=1)),
        pytest.approx(7, rel=1e-3),
    ),
    "video_encoders": (fails(1, "color", ENCODER), "no encoder"),
    "openxr_pixel_sensor": (
        becomes(3, "world_left", lambda: camera(grey=150, backend="openxr")),
        pytest.approx(1.5),
    ),
    "openxr_local_space": (becomes(3, "head_pose", lambda: away(0.1)), pytest.approx(100)),
    "openxr_loader": (fails(3, "depth", "xrCreateInstance: XrResult (-2)"), "xrCreateInstance"),
    "tracker_layouts": (
        becomes(0, "gaze", lambda: readings(60, lambda _: (0, 0, 0, 0, 0, 0, 2), backend="sdk")),
        pytest.approx(2),
    ),
    "trackers_need_head": (
        fails(0, "gaze", "MLHeadTrackingCreate: UnspecifiedFailure (4)"),
        "gaze: MLHeadTrackingCreate",
    ),
    "hand_key_points": (
        becomes(0, "hand_left", lambda: readings(60, scattered, backend="sdk")),
        pytest.approx(30),
    ),
    "controller_layout": (
        fails(0, "controller_joy", "MLInputGetControllerStateEx: trigger is not a number"),
        "not a number",
    ),
    "controller_library": (fails(0, "controller_joy", LIBRARY), "libinput.magicleap.so"),
    "controller_paths": (
        fails(3, "controller_joy", f"{PROFILE}: XR_ERROR_PATH_UNSUPPORTED (-22)"),
        PROFILE,
    ),
    "mltime": (fails(0, "head_pose", MLTIME), "MLTimeConvert"),
    "color_camera_ids": (
        fails(0, "color", "this headset lists no camera 1; it lists: 0"),
        "it lists: 0",
    ),
    "vendor_symbols": (fails(0, "gaze", SYMBOL), "MLEyeTrackingGetStateEx"),
    "camera_pose_axes": (becomes(0, "tf_world_center", backward), pytest.approx(120)),
    "marker_session": (
        fails(3, "markers", "xrCreateMarkerDetectorML: XrResult (-2)"),
        "xrCreateMarkerDetectorML",
    ),
    "marker_limit": (becomes(3, "markers", lambda: markers(17)), 17),
    "marker_axes": (becomes(3, "markers", lambda: markers(kind="april_tag")), 0),
    "map_session": (
        fails(3, "map", "not available: XR_ML_localization_map"),
        "XR_ML_localization_map",
    ),
    "map_events": (becomes(3, "map", lambda: localization(2)), pytest.approx(2)),
    "map_axes": (becomes(3, "tf_map", lambda: map_of_world(90)), pytest.approx(90)),
    "depth_is_radial": (becomes(0, "depth", bowl), None),
    "depth_confidence": (
        becomes(2, "depth", lambda: confident(lambda z: z)),
        pytest.approx(1),
    ),
}


@functools.cache
def verdicts_otherwise(fact: str) -> list[Verdict]:
    sessions = sound()
    OTHERWISE[fact][0](sessions)
    return judge(evidence_of(sessions))


def tilted(vector: Any) -> Any:
    return Rotation.from_euler("z", 45, degrees=True).apply(vector)


def scattered(_: float) -> Any:
    return np.ravel([(0.3 * it, 0, 0, 0, 0, 0, 1) for it in range(JOINTS)])


def test_a_headset_as_assumed_confirms_every_fact_that_recordings_can_tell() -> None:
    found = {it.fact: it for it in judge(evidence_of(sound()))}
    assert [it for it in found.values() if it.verdict != "as assumed"] == []
    assert found.keys() == {it for it in FACTS if "unjudged" not in FACTS[it]}


@pytest.mark.parametrize("fact", OTHERWISE)
def test_of_a_headset_that_differs_in_one_fact_only_this_row_differs(fact: str) -> None:
    _, measured = OTHERWISE[fact]
    (found,) = [it for it in verdicts_otherwise(fact) if it.verdict == "differs"]
    assert found.fact == fact
    if isinstance(measured, str):
        assert measured in str(found.measured)
    elif measured is not None:
        assert found.measured == measured
        assert found.margin is not None
        assert found.margin > 1


@pytest.mark.parametrize("fact", OTHERWISE)
def test_a_switch_is_a_legal_value_of_a_key_that_the_fact_names(fact: str) -> None:
    (found,) = [it for it in verdicts_otherwise(fact) if it.fact == fact]
    if not found.switch:
        return
    key, _, value = found.switch.partition("=")
    assert key in FACTS[fact]["keys"]
    section, _, name = key.partition(".")
    assert name in load_table().sections[section].keys
    assert value


def test_a_fact_that_recordings_do_not_show_is_unknown_and_says_why() -> None:
    verdicts = judge(Evidence([]))
    assert {it.verdict for it in verdicts} == {"unknown"}
    assert all(it.measured for it in verdicts)


def test_a_missing_permission_refutes_nothing() -> None:
    sessions = sound()
    reason = "MLEyeTrackingCreate: PermissionDenied (7)"
    sessions[0]["gaze"] = StreamEvidence({"backend": "sdk"}, [reason], denied=True)
    del sessions[1]["gaze"]
    assert [it for it in judge(evidence_of(sessions)) if it.verdict == "differs"] == []


@pytest.mark.parametrize("share", [0.1, 0.25, 0.5])
def test_images_that_a_busy_machine_left_out_refute_nothing(share: float) -> None:
    sessions = sound()
    for id in WORLD:
        # Nearly all are missing, in no regular pattern, and their numbers with them.
        kept = np.random.default_rng(4).random(len(sessions[0][id].times_ns)) < share
        kept[:2] = True
        old = sessions[0][id]
        old.times_ns = [it for it, is_kept in zip(old.times_ns, kept, strict=True) if is_kept]
        old.frames = [(stamp, number) for number, (stamp, _) in enumerate(old.times_ns)]
    assert [it for it in judge(evidence_of(sessions)) if it.verdict == "differs"] == []


def test_head_trackers_that_nobody_gets_are_not_too_many() -> None:
    sessions = sound()
    for session in sessions:
        for id in session.keys() & {"tf", "gaze", "hand_left", "hand_right", "controller"}:
            reasons = ["MLHeadTrackingCreate: UnspecifiedFailure (4)"]
            session[id] = StreamEvidence({"backend": "sdk"}, reasons)
    found = {it.fact: it for it in judge(evidence_of(sessions))}
    assert found["trackers_need_head"].verdict == "unknown"


def test_a_line_of_the_devices_log_refutes_the_instant_of_poses() -> None:
    line = "W ml2s: MLPerceptionGetPredictedSnapshot: InvalidTimestamp (15)"
    verdicts = judge(Evidence(sound(), log=[line], is_encrypted=True))
    assert [it.fact for it in verdicts if it.verdict == "differs"] == ["refused_pose_instant"]


@pytest.mark.parametrize("name", STRUCTS)
def test_bytes_behind_a_struct_are_counted_and_name_it(name: str) -> None:
    log = [line for it in STRUCTS for line in dumped(it, beyond=30 if it == name else 0)]
    (found,) = [it for it in judge(Evidence(sound(), log=log)) if it.verdict == "differs"]
    assert (found.fact, found.measured) == ("vendor_structs", f"30 bytes behind {name}")
    key, _, value = found.switch.partition("=")
    assert (key, value) == (f"{STRUCTS[name]}.backend", "openxr")
    assert key in FACTS["vendor_structs"]["keys"]


def test_a_struct_that_was_not_dumped_leaves_the_sizes_unknown() -> None:
    log = [line for it in [*STRUCTS][1:] for line in dumped(it)]
    found = {it.fact: it for it in judge(Evidence(sound(), log=log))}
    assert found["vendor_structs"].measured == "the log has no dump of MLWorldCameraData"


def test_verdicts_are_objects_with_five_keys() -> None:
    keys = ["fact", "verdict", "measured", "unit", "switch"]
    assert all(list(it) == keys for it in as_objects(judge(evidence_of(sound()))))


def test_video_alone_shows_no_brightness() -> None:
    sessions = sound()
    for session in sessions:
        if "world_left" in session:
            session["world_left"].greys = []
    found = {it.fact: it.verdict for it in judge(evidence_of(sessions))}
    assert found["normal_exposure_stream"] == found["openxr_pixel_sensor"] == "unknown"


def test_depth_without_a_wall_shows_no_kind_of_distance() -> None:
    sessions = sound()
    rough = wall() + np.random.default_rng(2).normal(0, 0.05, (480, 544)).astype(np.float32)
    sessions[0]["depth"].depths = {0: rough}
    found = {it.fact: it for it in judge(evidence_of(sessions))}
    assert found["depth_is_radial"].measured == "no wall is in view"


@pytest.mark.parametrize(
    ("far_m", "confidence"), [(1, lambda z: 1 / z), (2, np.zeros_like), (2, np.sin)]
)
def test_confidence_without_an_order_by_distance_is_unknown(far_m: float, confidence: Any) -> None:
    sessions = sound()
    sessions[2]["depth"] = confident(lambda z: confidence(20 * z), far_m)
    found = {it.fact: it for it in judge(evidence_of(sessions))}
    assert found["depth_confidence"].verdict == "unknown"


def test_samples_that_a_stalled_machine_received_late_refute_no_clock() -> None:
    sessions = sound()
    for id in (*(f"accel_{it}" for it in UNITS), *MAGNETOMETERS, "head_pose"):
        it = sessions[0][id]
        end_ns = it.times_ns[-1][0] + LATE_NS
        it.times_ns = [(stamp, end_ns) for stamp, _ in it.times_ns]
    assert [it for it in judge(evidence_of(sessions)) if it.verdict == "differs"] == []

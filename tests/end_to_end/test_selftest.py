"""Judges recordings of a simulated headset that is as assumed, or differs in one fact."""

from __future__ import annotations

import io
import json
import subprocess
import zipfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import psutil
import pytest

from adb_stand_in import APP, SERIAL, installed
from configurations import only
from ml2_receiver.errors import RecordingError
from ml2_tools.bags.bag_reader import Bag
from ml2_tools.selftest.evidence import Evidence, SessionStreams, read_session
from ml2_tools.selftest.judge import judge, judge_fact
from ml2_tools.selftest.pairing import pair
from ml2_tools.selftest.sessions import STEPS, Sections
from ml2_tools.selftest.verdict import Verdict
from processes import (
    HEADSET,
    PLAINTEXT,
    RECEIVER,
    Security,
    ended,
    headset_command,
    isolated_environment,
    paired,
    process,
    recorded_walk,
    start,
)
from simulation import STILL
from waiting import await_true

# Judgements need the controller, and markers that the detector looks for.
SHOWN = "controller_tracked=1", "tags=36h11"
SELFTEST = (str(RECEIVER), "headset", "selftest")

# A busy machine leaves images out, so that their rate is not known. Nothing here is behind adb.
_RATES = {"camera_rates", "depth_rates", "jpeg_encoder", "video_encoders"}
_MAY_BE_UNKNOWN = {*_RATES, "adb"}
# The head has to turn, and somebody to press all buttons.
_TAKE_LONGEST = {
    "everything": {"inertial_rate_and_axes"},
    "openxr": {"controller_paths", "openxr_local_space", "marker_limit", "map_axes"},
}
# They repeat after this time.
_LOOP_S = 4.0
_EVERYTHING, _OPENXR = STEPS["everything"], STEPS["openxr"]


def _of(*sections: str, step: Sections = _EVERYTHING) -> Sections:
    return {it: step[it] for it in sections}


# Facts that a key of the simulation turns round: what has to run, the key, and what the verdict
# names; None where that depends on how long the test runs. docs/unconfirmed.md has all keys.
OTHERWISE: Mapping[str, tuple[Sections, str, str | float | None]] = {
    "null_buffers": (_of("depth_center"), "assume.null_buffers=0", "depth flags"),
    "camera_rates": (_of("world_left", "head_pose"), "fault.world.drop_every=2", 15.0),
    "frame_number_gaps": (_of("world_left"), "assume.frame_number_gaps=2", 0.5),
    "magnetometer_calibrated": (
        _of("magnetometer"),
        "assume.magnetometer_calibrated=2",
        94.9,
    ),
    "sensor_names": (_of("magnetometer"), "assume.sensor_names=IMU", "it lists: IMU"),
    "hand_key_points": (_of("hands"), "assume.hand_key_points=16", 0.0),
    "depth_is_radial": (_of("depth_center"), "assume.depth_is_radial=0", 0.225),
    "openxr_local_space": (
        _of("head_pose", step=_OPENXR),
        "assume.openxr_local_space=0.1",
        100.0,
    ),
    "marker_session": (
        _of("markers", step=_OPENXR),
        "openxr.fault.markers.unsupported=1",
        "does not detect",
    ),
    "map_session": (
        _of("map", step=_OPENXR),
        "openxr.fault.extension.missing=XR_ML_localization_map",
        "XR_ML_localization_map",
    ),
    "vendor_symbols": (
        _of("gaze"),
        "assume.vendor_symbols=MLEyeTrackingGetStateEx",
        "libperception.magicleap.so/MLEyeTrackingGetStateEx",
    ),
    "vendor_structs": (
        _of("gaze"),
        "assume.vendor_structs=12",
        "12 bytes behind MLEyeTrackingStateEx",
    ),
    "tracker_layouts": (_of("gaze"), "assume.tracker_layouts=3", "MLEyeTrackingGetStateEx"),
    "trackers_need_head": (_of("gaze"), "assume.trackers_need_head=1", "MLHeadTrackingCreate"),
    "depth_confidence": (
        _of("depth_center", step=STEPS["other_modes"]),
        "assume.depth_confidence=0",
        0.5,
    ),
    "camera_pose_axes": (_of("world_center"), "assume.camera_pose_axes=180", 175.0),
    "marker_axes": (_of("markers", step=_OPENXR), "assume.marker_axes=180", 0.0),
    "marker_limit": (_of("markers", step=_OPENXR), "assume.marker_limit=20", 20.0),
    "map_axes": (_of("map", step=_OPENXR), "assume.map_axes=90", 90.0),
    "map_events": (_of("map", step=_OPENXR), "openxr.fault.map.silent=1", None),
    "mltime": (_of("head_pose"), "fault.time.convert=1", "MLTimeConvert"),
}


def record(
    folder: Path,
    sections: Sections,
    is_enough: Callable[[Evidence], bool],
    *simulated: str,
    least_s: float = 0.0,
    security: Security = PLAINTEXT,
) -> Evidence:
    """Records a headset until its evidence is enough, and returns it.

    A recording of less than `least_s` is not decoded to judge it.
    """
    folder.mkdir()
    config = folder / "config.yaml"
    config.write_text(only(sections))
    options = [word for key in simulated for word in ("--simulate", key)]
    recorded_walk(
        config,
        folder,
        lambda it: duration_s(it) >= least_s and is_enough(_evidence(folder, it)),
        *(*STILL, *options),
        security=security,
    )
    return _evidence(folder, folder / "walk")


def duration_s(walk: Path) -> float:
    """The time from the first message of a recording to the last; negative if there is none yet."""
    try:
        bag = Bag(walk)
        return (bag.end_ns - bag.begin_ns) / 1e9
    except RecordingError:
        return -1.0


def _evidence(folder: Path, walk: Path) -> Evidence:
    try:
        session: SessionStreams = read_session(walk)
    except RecordingError:  # nothing is written yet
        session = {}
    file = folder / "headset.log"
    return Evidence([session], log=file.read_text().splitlines() if file.exists() else [])


def together(*evidence: Evidence) -> Evidence:
    sessions = [session for it in evidence for session in it.sessions]
    return Evidence(sessions, log=[line for it in evidence for line in it.log or ()])


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Evidence:
    """The sessions of all steps with a headset that is as assumed, and is paired.

    In one more session, a permission is missing.
    """
    folder = tmp_path_factory.mktemp("sound")
    keys = paired(folder)

    def is_enough(step: str, evidence: Evidence) -> bool:
        (session,) = evidence.sessions
        judged = {id: it for id, it in session.items() if id != "light_sensor"}
        is_delivered = len(judged) > 1 and all(it.is_delivered for it in judged.values())
        return is_delivered and all(
            judge_fact(it, evidence).verdict != "unknown" for it in _TAKE_LONGEST.get(step, ())
        )

    whole = [
        record(
            folder / it,
            STEPS[it],
            partial(is_enough, it),
            *SHOWN,
            least_s=_LOOP_S if it in _TAKE_LONGEST else 0.0,
            security=keys,
        )
        for it in STEPS
    ]
    denied = record(
        folder / "denied",
        _of("world_left", step=_OPENXR),
        lambda it: any(stream.denied for session in it.sessions for stream in session.values()),
        "openxr.fault.sensor.denied=/pixelsensor/world/left",
    )
    return replace(together(*whole, denied), is_encrypted=True)


def differing(evidence: Evidence, flipped: str = "") -> list[Verdict]:
    """The facts that differ, without other rates than the one that is turned round."""
    found = [it for it in judge(evidence) if it.verdict == "differs"]
    return [it for it in found if it.fact not in _RATES - {flipped}]


def test_the_simulated_headset_is_as_assumed(sound: Evidence) -> None:
    found = {it.fact: it for it in judge(sound)}
    assert differing(sound) == []
    not_shown = {it.fact for it in found.values() if it.verdict == "unknown"}
    assert not_shown <= _MAY_BE_UNKNOWN
    assert len(found) >= 41


@pytest.mark.parametrize("fact", OTHERWISE)
def test_a_key_of_the_simulation_makes_one_row_differ(
    fact: str, sound: Evidence, tmp_path: Path
) -> None:
    sections, key, measured = OTHERWISE[fact]

    def differs(evidence: Evidence) -> bool:
        return judge_fact(fact, together(evidence, sound)).verdict == "differs"

    flipped = record(tmp_path / "flipped", sections, differs, *SHOWN, key)
    (found,) = differing(together(flipped, sound), fact)
    assert found.fact == fact
    if isinstance(measured, str):
        assert measured in str(found.measured)
    elif measured is not None:
        assert found.measured == pytest.approx(measured, rel=0.2, abs=1e-3)


def selftest(report: Path, *options: str) -> list[str]:
    """The command that tests a headset in the last two steps, or the options' choice."""
    skipped = [word for it in ("everything", "video") for word in ("--skip", it)]
    return [*SELFTEST, "--out", str(report), *skipped, *options]


def test_a_simulated_headset_that_ends_says_why(tmp_path: Path) -> None:
    report = tmp_path / "report.zip"
    done = ended(selftest(report, "--simulated", "no.such=1"), isolated_environment())
    assert done.returncode == 2
    assert (
        'the simulated headset has ended: Error: the simulated device: unknown key "no.such"'
        in (done.stderr)
    )
    assert not report.exists()


def test_the_command_says_what_differs(tmp_path: Path) -> None:
    report = tmp_path / "report.zip"
    fault = ("--skip", "other_modes", "--json", "--simulated", "openxr.fault.instance.fails=1")
    done = ended(selftest(report, *fault), isolated_environment())
    assert done.returncode == 1, done.stderr
    with zipfile.ZipFile(report) as archive:
        verdicts = json.loads(archive.read("verdicts.json"))
    assert json.loads(done.stdout) == verdicts
    (found,) = (it for it in verdicts if it["verdict"] == "differs")
    assert (found["fact"], found["switch"]) == ("openxr_loader", "world_center.backend=sdk")
    assert "xrCreateInstance" in found["measured"]
    assert [it["verdict"] for it in verdicts if it["fact"] == "keystore_tls"] == ["as assumed"]


@dataclass(frozen=True)
class Killed:
    """A test that was killed in its last step.

    Attributes:
        folder: where it makes temporary files.
        reports: the file after each step before it.
        processes: its children, at that moment.
    """

    folder: Path
    reports: Mapping[str, bytes]
    processes: Sequence[psutil.Process]


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Killed:
    report = tmp_path_factory.mktemp("killed") / "report.zip"
    *earlier, last = STEPS
    reports: dict[str, bytes] = {}
    command = [*SELFTEST, "--out", str(report), "--simulated"]
    environment = isolated_environment() | {"TMPDIR": str(report.parent)}
    with start(command, env=environment, stderr=subprocess.PIPE) as running:
        try:
            for number, step in enumerate(earlier, 1):
                line_of(running, f"{number} of {len(STEPS)}: {step}: ")
                reports[step] = report.read_bytes()
            itself = psutil.Process(running.pid)
            await_true(lambda: any(f"{last}.yaml" in it for it in commands_of(itself)))
            processes = itself.children(recursive=True)
        finally:
            running.kill()
    assert report.read_bytes() == reports[earlier[-1]]
    return Killed(report.parent, reports, processes)


def line_of(running: subprocess.Popen[str], words: str) -> None:
    assert running.stderr is not None
    assert any(words in line for line in running.stderr), f"expected {words}"


def commands_of(process: psutil.Process) -> list[str]:
    """The command lines of a process's children."""
    with suppress(psutil.Error):  # one may just have ended
        return [" ".join(it.cmdline()) for it in process.children(recursive=True)]
    return []


@pytest.mark.parametrize("step", [*STEPS][:-1])
def test_a_test_that_is_killed_keeps_what_was_found(step: str, killed: Killed) -> None:
    with zipfile.ZipFile(io.BytesIO(killed.reports[step])) as archive:
        assert archive.testzip() is None
        assert len(json.loads(archive.read("verdicts.json"))) >= 30


def test_a_test_that_is_killed_leaves_neither_processes_nor_recordings(killed: Killed) -> None:
    assert len(killed.processes) >= 3  # headset, receiver, and what removes the recordings
    await_true(lambda: not any(map(is_alive, killed.processes)))
    assert not list(killed.folder.glob("ml2-selftest-*"))


def is_alive(process: psutil.Process) -> bool:
    with suppress(psutil.NoSuchProcess):
        return process.is_running() and process.status() != psutil.STATUS_ZOMBIE
    return False


def test_a_headset_behind_adb_is_started_and_its_log_is_read(network: str, tmp_path: Path) -> None:
    line = f"W ml2s: MLPerceptionGetPredictedSnapshot: InvalidTimestamp (15) of {SERIAL}"
    user = tmp_path / "config"
    environment = isolated_environment() | installed(tmp_path, warnings=[line])
    environment |= {"XDG_CONFIG_HOME": str(user), "JDK_JAVA_OPTIONS": f"-Duser.home={tmp_path}"}
    keys = Security(("--keys", user / "ml2-sensors"), ("--keys", tmp_path / "headset"))
    pair([RECEIVER, "pair", *keys.receiver], [HEADSET, *keys.headset])
    here = ("ip", "netns", "exec", network)
    headset = headset_command("127.0.0.1:7755", *STILL, security=keys)
    report = tmp_path / "report.zip"
    with process([*here, *headset], environment, tmp_path / "headset.log", is_read=False):
        done = ended([*here, *selftest(report, "--skip", "openxr", "--json")], environment)
    assert done.returncode == 1, done.stderr
    verdicts = {it["fact"]: it["verdict"] for it in json.loads(done.stdout)}
    assert [it for it in verdicts if verdicts[it] == "differs"] == ["refused_pose_instant"]
    assert verdicts["keystore_tls"] == verdicts["adb"] == "as assumed"
    with zipfile.ZipFile(report) as archive:
        texts = {it: archive.read(it) for it in archive.namelist()}
    assert "MLPerceptionGetPredictedSnapshot" in texts["log.txt"].decode()
    assert [it for it, text in texts.items() if SERIAL.encode() in text] == []
    assert f"{APP}.START" in (tmp_path / "calls").read_text()

"""Mounts of inertial units: found by the command, kept in a file, and published."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bags import Messages, write_bag
from fake_sink import FakeSink
from head_motion import HeadMotion
from ml2_receiver.cli import main
from ml2_receiver.configuration.mounts import Mount, load_mounts, mounts_file, save_mounts
from ml2_receiver.errors import CalibrationError
from ml2_receiver.session.sink import Applied
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.mounted_sink import MountedSink
from ml2_receiver.wire.messages import StreamAnswer
from ros_messages import TYPES, header, imu, message, payload, string, transform

PREFIX = "/magic_leap2"
CONFIG = '{"headset": "h", "session": "s", "streams": {}, "device_id": "one"}'
MOUNT = Mount(
    translation_m=(0.02, 0.07, 0.01),
    rotation=(0.5, -0.5, 0.5, -0.5),
    time_offset_s=0.001,
    gyroscope_bias=(0.0, 0.1, 0.2),
    accelerometer_bias=(0.0, 0.1, 0.2),
    translation_sigma_m=(0.001, 0.001, 0.002),
    rotation_sigma_deg=(0.01, 0.02, 0.03),
    time_offset_sigma_s=1e-4,
    calibrated="2026-01-01T00:00:00+00:00",
)
(STATIC,) = (it for it in load_table().streams["tf"].topics if it.role == "tf_static")


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))


def write_motion(folder: Path, motion: HeadMotion) -> Path:
    """Records 25 s, with the halves of the left unit in topics of their own."""
    types = {
        f"{PREFIX}/config": "std_msgs/msg/String",
        f"{PREFIX}/head_pose": "geometry_msgs/msg/PoseStamped",
        f"{PREFIX}/gyro_left/imu": "sensor_msgs/msg/Imu",
        f"{PREFIX}/accel_left/imu": "sensor_msgs/msg/Imu",
    }

    def stamped(frame: str, at_s: float) -> tuple[int, Any]:
        ns = round(at_s * 1e9)
        return ns, header(frame, *divmod(ns, 10**9))

    def messages() -> Messages:
        yield f"{PREFIX}/config", 0, string(CONFIG)
        seen = motion.observed(25.0)
        places, turns = seen.poses.positions_m, seen.poses.rotations.as_quat()
        for at_s, place, turn in zip(seen.poses.stamps_s, places, turns, strict=True):
            ns, head = stamped("magicleap_world", at_s)
            pose = message(
                "geometry_msgs/msg/Pose",
                message("geometry_msgs/msg/Point", *place),
                message("geometry_msgs/msg/Quaternion", *turn),
            )
            yield f"{PREFIX}/head_pose", ns, payload(types[f"{PREFIX}/head_pose"], head, pose)
        for at_s, rate in zip(seen.gyroscope.stamps_s, seen.gyroscope.values, strict=True):
            ns, head = stamped("imu_left_frame", at_s)
            yield f"{PREFIX}/gyro_left/imu", ns, imu(head, tuple(rate), (0, 0, 0))
        for at_s, force in zip(seen.accelerometer.stamps_s, seen.accelerometer.values, strict=True):
            ns, head = stamped("imu_left_frame", at_s)
            yield f"{PREFIX}/accel_left/imu", ns, imu(head, (0, 0, 0), tuple(force))

    write_bag(folder, types, messages())
    return folder


def write_configuration(folder: Path, config: str) -> Path:
    topic = f"{PREFIX}/config"
    write_bag(folder, {topic: "std_msgs/msg/String"}, [(topic, 0, string(config))])
    return folder


def test_the_command_saves_the_mount_of_the_headset_and_forgets_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_mounts({"another": {"imu_right": MOUNT}})
    motion = HeadMotion(seed=6)
    assert main(["calibrate", "imu", "--bag", str(write_motion(tmp_path / "bag", motion))]) == 0
    shown = capsys.readouterr().out
    found = load_mounts()
    assert found["another"] == {"imu_right": MOUNT}
    mount = found["one"]["imu_left"]
    assert np.allclose(mount.translation_m, motion.mount.translation_m, atol=0.005)
    assert np.allclose(
        mount.rotation, motion.mount.rotation.as_quat(canonical=True), atol=np.radians(0.1)
    )
    x, y, z = 1e3 * np.array(mount.translation_m)
    assert f"{x:.1f}, {y:.1f}, {z:.1f}" in shown
    assert "compute pack" in shown

    assert main(["calibrate", "imu", "--forget"]) == 0
    assert load_mounts() == {}


def test_a_recording_that_names_no_device_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "bag"
    config = CONFIG.replace(', "device_id": "one"', "")
    write_bag(
        bag, {f"{PREFIX}/config": "std_msgs/msg/String"}, [(f"{PREFIX}/config", 0, string(config))]
    )
    assert main(["calibrate", "imu", "--bag", str(bag)]) == 2
    assert "does not say which headset" in capsys.readouterr().err


def test_a_recording_without_poses_or_units_is_refused_with_what_to_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = tmp_path / "bag"
    write_bag(
        bag, {f"{PREFIX}/config": "std_msgs/msg/String"}, [(f"{PREFIX}/config", 0, string(CONFIG))]
    )
    assert main(["calibrate", "imu", "--bag", str(bag)]) == 2
    assert "head_pose.enabled" in capsys.readouterr().err


def test_a_file_keeps_what_was_saved() -> None:
    assert load_mounts() == {}
    save_mounts({"one": {"imu_left": MOUNT}})
    assert load_mounts() == {"one": {"imu_left": MOUNT}}


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("rotation: [0.5, ", "rotation: [0.9, "),
        ("rotation: [0.5, ", "rotation: ["),
        ("translation_m: [0.02, ", "translation_m: [.nan, "),
        ("translation_m: [0.02, ", "translation_m: [x, "),
        ("translation_m:", "translation:"),
        ("imu_left:", "imu_left: 3\n  more:"),
        ("one:", "- one:"),
        ("one:", "one: {"),
    ],
)
def test_a_changed_file_is_refused_with_its_path(before: str, after: str) -> None:
    save_mounts({"one": {"imu_left": MOUNT}})
    text = mounts_file().read_text()
    assert before in text
    mounts_file().write_text(text.replace(before, after, 1))
    with pytest.raises(CalibrationError, match=str(mounts_file())):
        load_mounts()


def applied(*topics: Any, session: str = "s", device_id: str = "one") -> Applied:
    streams = {"tf": StreamAnswer("applied", {})}
    return Applied("h", session, streams, topics, device_id=device_id)


def mounted() -> tuple[FakeSink, MountedSink]:
    inner = FakeSink()
    return inner, MountedSink(inner, {"one": {"imu_left": MOUNT}}, "robot1/")


def transforms(data: bytes) -> list[tuple[str, str, tuple[float, ...]]]:
    """Read by rosbags: parent, child, and the seven numbers of each."""
    found: list[tuple[str, str, tuple[float, ...]]] = []
    read: Any = TYPES.deserialize_cdr(data, STATIC.type)
    for it in read.transforms:
        t, r = it.transform.translation, it.transform.rotation
        numbers = (t.x, t.y, t.z, r.x, r.y, r.z, r.w)
        found.append((it.header.frame_id, it.child_frame_id, numbers))
    return found


OURS = ("robot1/head_frame", "robot1/imu_left_frame", MOUNT.translation_m + MOUNT.rotation)


def test_a_headset_without_static_transforms_gets_a_topic_of_them_once_a_session() -> None:
    inner, sink = mounted()
    sink.configured(applied())
    sink.configured(applied())
    assert [transforms(it) for it in inner.payloads["/tf_static"]] == [[OURS]]
    assert all(list(it.topics) == [STATIC] for it in inner.applied)
    sink.configured(applied(session="next"))
    assert len(inner.payloads["/tf_static"]) == 2


@pytest.mark.parametrize("frame", ["", "a", "ab", "abc", "abcd", "camera_frame"])
def test_transforms_of_the_headset_come_with_the_mounts(frame: str) -> None:
    inner, sink = mounted()
    publish = sink.open(STATIC)
    sink.configured(applied(STATIC))
    assert not inner.payloads["/tf_static"]
    publish(bytearray(transform(header(frame, 1), frame, (1.0, 2.0, 3.0))))
    (of_headset, ours) = transforms(inner.payloads["/tf_static"][0])
    assert of_headset[:2] == (frame, frame)
    assert of_headset[2][:3] == (1.0, 2.0, 3.0)
    assert ours == OURS


def test_another_headset_gets_no_mounts() -> None:
    inner, sink = mounted()
    publish = sink.open(STATIC)
    sink.configured(applied(STATIC, device_id="another"))
    data = transform(header("a", 1), "b", (1.0, 2.0, 3.0))
    publish(bytearray(data))
    assert inner.payloads["/tf_static"] == [data]
    sink.configured(applied(device_id="another"))
    assert list(inner.applied[-1].topics) == []


def test_a_sink_that_refuses_the_topic_says_so() -> None:
    inner, sink = mounted()
    inner.unmakeable = {STATIC.type}
    sink.configured(applied())
    assert inner.events == [
        f"there is no {STATIC.type}",
        "/tf_static: the topic could not be opened",
    ]

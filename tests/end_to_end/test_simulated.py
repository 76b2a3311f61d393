"""Every sensor of the simulated headset reaches an independent rclpy subscriber."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import re
import signal
import subprocess
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from capture_stamps import stamp_ns
from configurations import only
from counters import assert_counters_agree, await_more, have_arrived
from full_load import FullLoad
from own_environment import MAY_MOUNT_AND_MAKE_NETWORKS
from processes import (
    HEADSET,
    PREFIX,
    ROOT,
    Received,
    headset_command,
    isolated_environment,
    line_with,
    process,
    receive,
    receive_command,
)
from promised_topics import ALL_OTHERS, INFRA, MIXED_REALITY
from simulation import CAMERAS, EYES, STILL, image_topic, raw_config
from waiting import LIMIT_S
from waiting_receiver import waiting_receiver

THESIS_CONFIG = ROOT / "host_receiver" / "test" / "data" / "thesis_config.yaml"
UPTIME = f"{PREFIX}/custom/app_uptime"
OWN_TOPICS = {f"{PREFIX}/config", f"{PREFIX}/log"}
GIVING_WAY = only(
    "world_left: {enabled: true}, other_sensors: {enabled: true}, head_pose: {enabled: true}"
)


@pytest.mark.skipif(not MAY_MOUNT_AND_MAKE_NETWORKS, reason="only root can mount")
def test_a_headset_runs_where_no_program_in_tmp_does() -> None:
    headset = [str(HEADSET), "--receiver", "127.0.0.1:1", "--insecure", "--simulate", "no.such=1"]
    # The clone may be in /tmp, too.
    mount = """mount --bind "$1" /mnt && mount -t tmpfs -o noexec tmp /tmp &&
        mkdir -p "$1" && mount --bind /mnt "$1" && shift && "$@\""""
    done = subprocess.run(
        ["unshare", "--mount", "bash", "-c", mount, "bash", ROOT, *headset],
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    assert 'the simulated device: unknown key "no.such"' in done.stderr  # by its native library


def test_every_sensor_arrives(received: Received) -> None:
    expected = {f"{PREFIX}/{topic}": type for topic, (type, _) in ALL_OTHERS.items()}
    expected["/tf"] = "tf2_msgs/msg/TFMessage"
    assert {name: kind for name, (kind, _) in received.topics.items()} == expected
    assert [name for name, (_, payloads) in received.topics.items() if not payloads] == []
    assert {answer["result"] for answer in received.snapshot["streams"].values()} == {"applied"}


def test_there_are_no_custom_topics_unless_the_user_enables_them(received: Received) -> None:
    assert UPTIME not in received.graph
    assert "custom" not in received.snapshot["streams"]


def test_publishers_offer_reliable_and_volatile(received: Received) -> None:
    assert all(qos == {("RELIABLE", "VOLATILE")} for qos in received.qos.values())


def test_every_message_carries_the_frame_of_its_sensor(received: Received) -> None:
    for topic, (type, frame) in ALL_OTHERS.items():
        for message in received.messages(topic):
            if type == "std_msgs/msg/String":
                assert json.loads(message.data)["frame_id"] == frame, topic
            else:
                assert message.header.frame_id == frame, topic


def test_all_topics_of_a_capture_share_one_stamp(received: Received) -> None:
    for camera in (*CAMERAS, *EYES):
        images = stamps_ns(received, image_topic(camera))
        assert len(set(images)) == len(images)
        assert_same_captures(stamps_ns(received, f"{camera}/metadata"), images)
        if camera in CAMERAS:
            assert_same_captures(stamps_ns(received, f"{camera}/camera_info"), images)
    for topic in ("depth/confidence", "depth/flags"):
        assert_same_captures(stamps_ns(received, topic), stamps_ns(received, "depth/image_raw"))


def assert_same_captures(some: list[int], others: list[int]) -> None:
    """Asserts that both have the same stamps, except for messages that a busy machine dropped."""
    assert set(some) & set(others)
    distances = np.abs(np.subtract.outer(np.array(some), np.array(others))).min(axis=1)
    assert ((distances == 0) | (distances > 16e6)).all()


def stamps_ns(received: Received, topic: str) -> list[int]:
    return [stamp_ns(message) for message in received.messages(topic)]


@pytest.mark.parametrize(
    ("topic", "encoding", "dtype", "shape"),
    [
        *((f"{camera}/image_raw", "mono8", np.uint8, (1016, 1016)) for camera in CAMERAS[:3]),
        *((f"{eye}/image_raw", "mono8", np.uint8, (400, 400)) for eye in EYES),
        ("depth/image_raw", "32FC1", np.float32, (480, 544)),
        ("depth/confidence", "32FC1", np.float32, (480, 544)),
        ("depth/flags", "32SC1", np.int32, (480, 544)),
    ],
)
def test_raw_images_show_a_moving_scene(
    received: Received, topic: str, encoding: str, dtype: type, shape: tuple[int, int]
) -> None:
    images = received.messages(topic)
    for image in images:
        assert (image.encoding, (image.height, image.width)) == (encoding, shape)
        assert image.step == shape[1] * np.dtype(dtype).itemsize
        assert len(image.data) == image.step * image.height
    pictures = {bytes(image.data) for image in images}
    assert len(pictures) > 10
    first: NDArray[Any] = np.frombuffer(pictures.pop(), dtype)
    assert len(np.unique(first[np.isfinite(first)])) > 2


def test_jpegs_show_a_moving_scene(received: Received) -> None:
    images = received.messages("color/image_raw/compressed")
    assert {image.format for image in images} == {"rgb8; jpeg compressed bgr8"}
    pictures = {bytes(image.data) for image in images}
    assert len(pictures) > 10
    picture = cv2.imdecode(np.frombuffer(pictures.pop(), np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape == (1080, 1920, 3)
    assert picture.std() > 10


@pytest.mark.parametrize("camera", [*CAMERAS, *EYES])
def test_frame_numbers_count_the_captures(flat: FullLoad, camera: str) -> None:
    numbers = sorted(frame_numbers(flat.received, camera).items())
    first_ns, first = numbers[0]
    # If a period has passed and no capture is counted, the camera has left one out to draw.
    rate_hz = flat.received.snapshot["streams"][camera]["values"]["update_rate"]
    left_out = [round((at - first_ns) * rate_hz / 1e9) - (it - first) for at, it in numbers]
    assert left_out == sorted(left_out)
    kind = {"color": "colour", "depth": "depth"}.get(camera, camera.split("_")[0])
    assert left_out[-1] <= flat.left_out.get(kind, 0)


def frame_numbers(received: Received, camera: str) -> dict[int, int]:
    """Returns the frame numbers in the metadata by stamp in ns."""
    metadata = received.messages(f"{camera}/metadata")
    assert metadata
    return {stamp_ns(it): json.loads(it.data)["frame_number"] for it in metadata}


def test_invalid_depth_is_nan_and_flagged(received: Received) -> None:
    flags = {stamp_ns(message): message for message in received.messages("depth/flags")}
    compared = 0
    for image in received.messages("depth/image_raw"):
        flag = flags.get(stamp_ns(image))
        if flag is None:
            continue
        depth = np.frombuffer(bytes(image.data), np.float32)
        bits = np.frombuffer(bytes(flag.data), np.int32)
        assert np.isnan(depth).any()
        assert (np.isnan(depth) == (bits != 0)).all()
        compared += 1
    assert compared > 10


def test_every_message_is_received_or_counted_as_dropped(received: Received) -> None:
    for topic, seen in received.snapshot["topics"].items():
        counters = received.counters(topic)
        dropped = sum(int(v) for k, v in counters.items() if k.startswith("dropped."))
        assert int(counters["produced"]) == int(counters["received"]) + dropped, topic
        assert int(counters["produced"]) == int(counters["received"]) + int(counters["gaps"]), topic
        assert seen["count"] <= int(counters["received"])


@pytest.fixture(scope="module")
def variant(tmp_path_factory: pytest.TempPathFactory) -> Received:
    folder = tmp_path_factory.mktemp("variant")
    config = folder / "variant.yaml"
    mixed_reality = "stream: 1, resolution_width: 648, resolution_height: 720"
    config.write_text(
        only(
            f"picture_center: {{enabled: true, {mixed_reality}}},"
            "depth_center: {enabled: true, stream: 0, update_rate: 5, format: DepthRaw},"
            "custom: {enabled: true}"
        )
    )
    is_enough = have_arrived({"custom/app_uptime": 11}, of_others=1)
    return receive(config, [*STILL], folder, is_enough=is_enough)


def test_mixed_reality_and_raw_depth_replace_color_and_depth(variant: Received) -> None:
    expected = {f"{PREFIX}/{topic}" for topic in (*MIXED_REALITY, *INFRA)} | {"/tf", UPTIME}
    assert variant.topics.keys() == expected
    for topic, (type, frame) in (MIXED_REALITY | INFRA).items():
        assert variant.topics[f"{PREFIX}/{topic}"][0] == type
        if type != "std_msgs/msg/String":
            assert {m.header.frame_id for m in variant.messages(topic)} == {frame}
    assert {m.encoding for m in variant.messages("infra/image_raw")} == {"32FC1"}
    metadata = json.loads(variant.messages("infra/metadata")[0].data)
    assert metadata["illumination"] == "on"


def test_messages_of_a_custom_topic_arrive_like_those_of_a_sensor(variant: Received) -> None:
    assert variant.topics[UPTIME][0] == "std_msgs/msg/Float64"
    uptimes_s = [message.data for message in variant.messages("custom/app_uptime")]
    assert len(uptimes_s) > 10
    assert min(b - a for a, b in itertools.pairwise(uptimes_s)) >= 0.1
    assert variant.qos[UPTIME] == {("RELIABLE", "VOLATILE")}
    assert variant.counters(UPTIME)["received"] == str(len(uptimes_s))
    assert_counters_agree(variant)
    assert variant.snapshot["streams"]["custom"]["result"] == "applied"


def published(received: Received) -> set[str]:
    """Returns the topics below the prefix in the ROS graph, whatever the receiver reports."""
    return {name for name in received.graph if name.startswith(f"{PREFIX}/")}


def test_only_enabled_streams_have_topics(variant: Received) -> None:
    assert published(variant) == variant.topics.keys() - {"/tf"} | OWN_TOPICS


def test_the_configuration_of_the_thesis_loads_and_runs_nothing(tmp_path: Path) -> None:
    received = receive(THESIS_CONFIG, [], tmp_path)
    assert received.snapshot["streams"] == {}
    assert published(received) <= OWN_TOPICS


def test_a_wrong_configuration_starts_nothing(tmp_path: Path) -> None:
    config = tmp_path / "wrong.yaml"
    config.write_text(raw_config(depth_center={"update_rate": 31}))
    run = subprocess.run(
        [str(word) for word in receive_command(config, "127.0.0.1:0")],
        check=False,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 2
    assert "depth_center.update_rate" in run.stderr
    assert "listening" not in run.stdout


@pytest.mark.parametrize(
    ("setting", "words"),
    [("speed=1", 'unknown key "speed"; the nearest is "seed"'), ("seed=x", 'found "x"')],
)
def test_a_wrong_key_of_the_simulation_is_an_error(setting: str, words: str) -> None:
    command = headset_command("127.0.0.1:1", "--simulate", setting)
    run = subprocess.run(command, check=False, capture_output=True, text=True)
    assert run.returncode == 2
    assert words in run.stderr


def test_the_keys_of_the_simulation_are_listed_with_default_and_meaning() -> None:
    command = headset_command("127.0.0.1:1", "--simulate", "help")
    lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()
    assert "fault.world.stalled=0  1: no frames come, Get times out (0 to 1)" in lines
    assert all(re.fullmatch(r"[a-z_.]+=\S*  .+", line) for line in lines)


def test_ctrl_c_ends_a_headset_that_was_started_to_ignore_it(tmp_path: Path) -> None:
    """A shell without job control starts background jobs so."""
    command = ["env", "--ignore-signal=INT", *headset_command("127.0.0.1:1")]
    with process(command, isolated_environment(), tmp_path / "headset.log") as headset:
        line_with(headset, "connecting to")
        headset.send_signal(signal.SIGINT)
        assert headset.wait(LIMIT_S) == 0


def test_stamps_of_200_hz_are_5_ms_apart(received: Received) -> None:
    steps = np.diff(stamps_ns(received, "gyro_left/imu"))
    periods = np.round(steps / 5e6)  # above 1 if a busy machine dropped some
    # On a busy machine the estimated skew may be wrong by all that is allowed, like the slew.
    slewed = periods * 5e6 * (500e-6 + 500e-6) + 1
    withheld = received.counters(f"{PREFIX}/gyro_left/imu").get("dropped.clock_step", "0")
    jumps = int(received.snapshot["clock"]["epoch"]) + int(withheld)
    assert np.count_nonzero(np.abs(steps - periods * 5e6) > slewed) <= jumps


def niceness(pid: int) -> dict[str, set[int]]:
    """Returns the niceness that the threads of each name have."""
    found: dict[str, set[int]] = {}
    for thread in Path(f"/proc/{pid}/task").iterdir():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # if it has ended
            name = (thread / "comm").read_text().strip()
            found.setdefault(name, set()).add(os.getpriority(os.PRIO_PROCESS, int(thread.name)))
    return found


def test_threads_with_images_give_way(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(GIVING_WAY)
    with (
        waiting_receiver(config, tmp_path) as waiting,
        waiting.started("headset", headset_command(waiting.address, *STILL)) as headset,
    ):
        for topic in ("world_left/image_raw", "gyro_left/imu", "head_pose"):
            await_more(waiting.subscriber, topic)
        found = niceness(headset.pid)
    (urgent,), (images,) = found["ml2s blocking"], found["ml2s images"]
    assert urgent < images
    assert (found["ml2s head sdk"], found["ml2s world sdk"]) == ({urgent}, {images})

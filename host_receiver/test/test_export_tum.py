"""RGB-D data in the TUM format, read back by OpenCV and by the rules of the format."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import ros_messages
from command_line import refusal
from compressed_images import FORMAT, compressed_depth
from ml2_receiver.cli import main
from sound_bag import (
    HEIGHT,
    IMAGES,
    METADATA,
    SECOND_NS,
    WIDTH,
    D,
    K,
    Message,
    compressed,
    config,
    pixels,
    sound,
    written,
)

WALL_MM, BEHIND_M = 2000, 0.5
LATE_NS = 4_000_000
DEPTH_EVERY = 6


def depth(messages: list[Message]) -> list[Message]:
    """A depth camera 0.5 m behind the camera: a wall 2 m before it, at 5 Hz, 4 ms later."""
    header = [it for it in messages if it.topic == IMAGES]
    taken = {it.stamp_ns for it in header[::DEPTH_EVERY]}
    found = []
    for it in compressed(messages, "depth"):
        if it.stamp_ns not in taken or it.type == "sensor_msgs/msg/Imu":
            continue
        position = (1.0, 2.0, 3.0 - BEHIND_M)
        late = replace(
            it, stamp_ns=it.stamp_ns + LATE_NS, log_ns=it.log_ns + LATE_NS, position=position
        )
        if late.topic.endswith("compressedDepth"):
            stamp = ros_messages.header(late.frame, *divmod(late.stamp_ns, SECOND_NS))
            data = compressed_depth(np.full((HEIGHT, WIDTH), WALL_MM, np.uint16))
            late = replace(late, payload=ros_messages.compressed_image(stamp, FORMAT, data))
        found.append(late)
    return found


def recorded(tmp_path: Path, messages: list[Message]) -> list[str]:
    kept = [it for it in messages if it.topic != METADATA and not it.topic.endswith("/metadata")]
    bag = written(tmp_path / "bag", [config(), *kept])
    return ["export", "--tum", str(tmp_path / "out"), "--bag", str(bag)]


def listed(path: Path) -> list[list[str]]:
    return [line.split() for line in path.read_text().splitlines()]


def read(path: Path) -> Any:
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


def test_images_depth_and_poses_have_one_stamp(tmp_path: Path) -> None:
    messages = sound()
    words = recorded(tmp_path, [*messages, *depth(messages)])
    assert main([*words, "--cameras", "world_left"]) == 0
    out = tmp_path / "out"
    images = [it for it in messages if it.topic == IMAGES]
    stamps = [f"{it.stamp_ns // SECOND_NS}.{it.stamp_ns % SECOND_NS:09d}" for it in images]
    assert listed(out / "rgb.txt") == [[it, f"rgb/{it}.png"] for it in stamps]
    with_depth = stamps[::DEPTH_EVERY]
    assert listed(out / "depth.txt") == [[it, f"depth/{it}.png"] for it in with_depth]
    pairs = [[it, f"rgb/{it}.png", it, f"depth/{it}.png"] for it in with_depth]
    assert listed(out / "associations.txt") == pairs
    poses = listed(out / "groundtruth.txt")
    assert [it[0] for it in poses] == stamps
    assert [float(it) for it in poses[0][1:]] == [1, 2, 3, 0, 0, 0, 1]


def test_images_are_without_distortion(tmp_path: Path) -> None:
    messages = sound()
    words = recorded(tmp_path, [*messages, *depth(messages)])
    assert main([*words, "--cameras", "world_left"]) == 0
    matrix, size = np.array(K).reshape(3, 3), (WIDTH, HEIGHT)
    maps = cv2.fisheye.initUndistortRectifyMap(
        matrix, np.array(D), np.eye(3), matrix, size, cv2.CV_32FC1
    )
    files = sorted((tmp_path / "out/rgb").iterdir())
    for file, it in zip(files, [it for it in messages if it.topic == IMAGES], strict=True):
        expected = cv2.remap(pixels(it), *maps, cv2.INTER_LINEAR)
        off = np.abs(read(file).astype(int) - expected)[1:-1, 1:-1]
        assert off.max() <= 2 * 255 / 32, "positions are rounded to 1/32 px"


def test_depth_is_as_the_camera_sees_it(tmp_path: Path) -> None:
    messages = sound()
    words = recorded(tmp_path, [*messages, *depth(messages)])
    assert main([*words, "--cameras", "world_left"]) == 0
    for file in (tmp_path / "out/depth").iterdir():
        levels = read(file)
        assert (levels.shape, levels.dtype) == ((HEIGHT, WIDTH), np.uint16)
        # A wall 2 m before the depth camera, which stands 0.5 m behind; 5000 levels a metre.
        assert set(np.unique(levels)) <= {0, 7500}
        assert np.count_nonzero(levels) > levels.size / 4


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ([], "has no images with camera_info of color"),
        (["--cameras", "world_left", "color"], "--tum takes one camera, found world_left color"),
        (["--cameras", "world_left"], "has no images with camera_info of depth"),
    ],
)
def test_cameras_that_do_not_serve_are_refused(more: list[str], words: str, tmp_path: Path) -> None:
    assert words in refusal(*recorded(tmp_path, sound()), *more)
    assert not (tmp_path / "out").exists()


def test_a_depth_image_that_is_damaged_is_named(tmp_path: Path) -> None:
    messages = sound()
    damaged = [
        replace(it, payload=it.encoded()[:-20]) if it.topic.endswith("compressedDepth") else it
        for it in depth(messages)
    ]
    words = recorded(tmp_path, [*messages, *damaged])
    assert "/magic_leap2/depth/image_raw/compressedDepth: " in refusal(
        *words, "--cameras", "world_left"
    )

"""Inspects a recording of the simulated headset, and exports it to EuRoC's format."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import pytest

from bags import message_counts
from capture_stamps import stamp_ns
from configurations import only
from euroc import rows
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.bags.decoding import decoder
from processes import PREFIX, RECEIVER, draw_images, ended, recorded_walk

CONFIG = only("world_left: {enabled: true}, world_right: {enabled: true}, imu: {united: true}")
_IMAGES = 60
CAMERAS = {"cam0": "world_left", "cam1": "world_right"}
NOISE = ["accelerometer-noise-density", "accelerometer-random-walk"]
NOISE += ["gyroscope-noise-density", "gyroscope-random-walk"]


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("config") / "config.yaml"
    file.write_text(CONFIG)
    return file


@pytest.fixture(scope="module")
def bag(config: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of a walk with more than _IMAGES of each camera, made without ROS."""
    folder = tmp_path_factory.mktemp("recording")
    draw_images(config, ())
    return recorded_walk(config, folder, images_with_poses())


def images_with_poses() -> Callable[[Path], bool]:
    """Returns a predicate of a bag that grows: it has so many images that those before the first
    pose are less than a tenth."""
    before = dict.fromkeys(CAMERAS.values(), 0)

    def has_images(bag: Path) -> bool:
        counts = message_counts(bag)
        images = {it: counts.get(f"{PREFIX}/{it}/image_raw", 0) for it in before}
        if not counts.get("/tf"):
            before.update(images)
        return all(images[it] > _IMAGES + 10 * before[it] for it in before)

    return has_images


@pytest.fixture(scope="module")
def euroc(bag: Path) -> Path:
    folder = bag.parent / "euroc"
    noise = [f"--{name}=0.001" for name in NOISE]
    export: list[str | Path] = [RECEIVER, "export", "--euroc", folder, "--bag", bag]
    ended([*export, "--imu", "imu_left", *noise]).check_returncode()
    return folder


def recorded(bag: Path, topic: str) -> dict[int, Any]:
    """Returns the messages of a topic by stamp."""
    reader = BagReader(bag)
    name = f"{PREFIX}/{topic}"
    decode = decoder(reader.types[name])
    found = [decode(it.payload) for it in reader.messages() if it.topic == name]
    return {stamp_ns(it): it for it in found}


def lost_transforms(bag: Path) -> int:
    """Returns how many messages of /tf the recording's summary counts as lost."""
    log = (bag.parent / "receiver.log").read_text()
    found = re.search(r"^ */tf: \d+ dropped, (\d+) lost", log, re.MULTILINE)
    return int(found[1]) if found else 0


def test_images_have_camera_info_metadata_and_transforms(bag: Path) -> None:
    """Tolerates gaps, also of poses: a busy machine may simulate a capture too late."""
    inspect: list[str | Path] = [RECEIVER, "inspect", bag, "--json"]
    run = ended(inspect)
    checks = {(it["topic"], it["check"]): it for it in json.loads(run.stdout)}
    without = 0
    for camera in CAMERAS.values():
        image = f"{PREFIX}/{camera}/image_raw"
        for check in ("stamps", "jitter"):
            assert checks[image, check]["verdict"] == "ok", checks[image, check]
        for partner in ("camera_info", "metadata"):
            # A camera_info or metadata whose image was dropped is no error.
            pairs = checks[image, f"pairs with {partner}"]["figures"]
            assert (pairs["pairs"] > 0, pairs["images_alone"]) == (True, 0), pairs
        figures = checks[image, "transforms"]["figures"]
        assert figures["exact"] > 9 * figures["before_or_after"], figures
        without += figures["between"] + figures["uncovered"]
    assert without <= lost_transforms(bag)


@pytest.mark.parametrize(("folder", "camera"), CAMERAS.items())
def test_each_image_is_a_png_of_its_stamp(bag: Path, euroc: Path, folder: str, camera: str) -> None:
    images = recorded(bag, f"{camera}/image_raw")
    found = {int(at): name for at, name in rows(euroc, folder)}
    assert len(images) > _IMAGES
    assert list(found) == sorted(images)
    for at, name in found.items():
        png = cv2.imread(str(euroc / "mav0" / folder / "data" / name), cv2.IMREAD_UNCHANGED)
        assert png is not None
        assert png.tobytes() == bytes(images[at].data)


def test_each_inertial_sample_is_a_row(bag: Path, euroc: Path) -> None:
    samples = recorded(bag, "imu_left/imu")
    found = {int(at): [float(it) for it in values] for at, *values in rows(euroc, "imu0")}
    assert len(samples) > 400
    assert list(found) == sorted(samples)
    for at, values in found.items():
        w, a = samples[at].angular_velocity, samples[at].linear_acceleration
        assert values == pytest.approx([w.x, w.y, w.z, a.x, a.y, a.z])

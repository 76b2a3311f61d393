"""Images of a running receiver, here of a node that publishes a rendered walk."""

import functools
import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import rclpy
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from rclpy.context import Context
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header, String
from tf2_msgs.msg import TFMessage

from camera_messages import camera_info, stamped, transform_of
from command_line import refusal
from ml2_receiver.ros.context import end_node
from ml2_tools.errors import EvaluationError
from ml2_tools.evaluation import live
from ml2_tools.evaluation.live import record_live
from rendered_room import CAMERA, Walk
from waiting import LIMIT_S, await_true

PREFIX, CAMERA_NAME = "/live_test", "world_left"
FRAME, WORLD = "world_left_optical_frame", "magicleap_world"
WALK = Walk.about(1)


@functools.cache
def images() -> list[tuple[int, NDArray[np.uint8]]]:
    return list(WALK.images())


class Headset:
    """Publishes what a receiver would, of a headset that may compress the images."""

    def __init__(self, *, is_compressed: bool) -> None:
        self.is_compressed = is_compressed
        self.context = Context()
        rclpy.init(context=self.context)
        self.node: Node = rclpy.create_node("live_test", context=self.context)
        topic = f"{PREFIX}/{CAMERA_NAME}"
        depth = len(WALK.poses)  # so that none is overwritten on a slow machine
        name, type = f"{topic}/image_raw", Image
        if is_compressed:
            name, type = f"{name}/compressed", CompressedImage
        self._images = self.node.create_publisher(type, name, depth)
        self._infos = self.node.create_publisher(CameraInfo, f"{topic}/camera_info", depth)
        self._metadata = self.node.create_publisher(String, f"{topic}/metadata", depth)
        self._transforms = self.node.create_publisher(TFMessage, "/tf", 100)

    def walk(self) -> None:
        """Once somebody has subscribed to everything; twenty images a second."""
        publishers = (self._images, self._infos, self._metadata, self._transforms)
        await_true(lambda: all(it.get_subscription_count() for it in publishers))
        for (stamp_ns, pixels), pose in zip(images(), WALK.poses, strict=True):
            header, lens = stamped(FRAME, stamp_ns), CAMERA.lens
            place = transform_of(stamped(WORLD, stamp_ns), FRAME, pose[:3, 3])
            self._transforms.publish(TFMessage(transforms=[place]))
            size = (lens.width, lens.height)
            info = camera_info(header, size, lens.model, lens.coefficients, CAMERA.matrix)
            self._infos.publish(info)
            self._metadata.publish(String(data=_metadata(header.stamp)))
            self._images.publish(self._image(header, pixels))
            time.sleep(0.05)

    def _image(self, header: Header, pixels: NDArray[np.uint8]) -> Any:
        if self.is_compressed:
            data = cv2.imencode(".jpg", pixels)[1].tobytes()
            return CompressedImage(header=header, format="mono8; jpeg compressed mono8", data=data)
        image = Image(header=header, height=pixels.shape[0], width=pixels.shape[1])
        image.encoding, image.step, image.data = "mono8", pixels.shape[1], pixels.tobytes()
        return image

    def close(self) -> None:
        end_node(self.node)


def _metadata(stamp: Time) -> str:
    lens = CAMERA.lens
    intrinsics = {
        "width": lens.width,
        "height": lens.height,
        "focal_length": [lens.fx, lens.fy],
        "principal_point": [lens.cx, lens.cy],
        "distortion_model": lens.model,
        "distortion": list(lens.coefficients),
    }
    said = {"sec": stamp.sec, "nanosec": stamp.nanosec}
    return json.dumps({"stamp": said, "intrinsics": intrinsics})


@pytest.fixture
def headset(request: pytest.FixtureRequest, ros_of_children: None) -> Iterator[Headset]:
    headset = Headset(is_compressed=getattr(request, "param", False))
    yield headset
    headset.close()


@pytest.mark.parametrize("headset", [False, True], ids=["raw", "compressed"], indirect=True)
def test_what_arrives_until_the_end_is_recorded_and_all_of_it_can_be_evaluated(
    headset: Headset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live, "_PATIENCE_S", LIMIT_S)
    stopping, counts = threading.Event(), []

    def report(images: int) -> None:
        counts.append(images)
        if images == len(WALK.poses):
            stopping.set()

    walking = threading.Thread(target=headset.walk)
    walking.start()
    sequence = record_live(PREFIX, CAMERA_NAME, tmp_path, stopping, report)
    walking.join()
    assert counts == sorted(counts)
    assert sequence.camera.lens == CAMERA.lens
    assert sequence.stamps_ns == WALK.stamps_ns()
    for (found_ns, found), (true_ns, true) in zip(sequence.images(), images(), strict=True):
        assert found_ns == true_ns
        jpeg = cv2.imencode(".jpg", true)[1]
        decoded = cv2.imdecode(jpeg, cv2.IMREAD_GRAYSCALE)
        assert np.array_equal(found, decoded if headset.is_compressed else true)
    assert [pose[:3, 3].tolist() for _, pose in sequence.reference] == pytest.approx(
        np.array([pose[:3, 3] for pose in WALK.poses])
    )


def test_without_a_headset_it_says_what_to_start(
    headset: Headset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live, "_PATIENCE_S", 0.3)
    assert "is `ml2-receiver run` running" in refusal(
        "evaluate", "--live", "--prefix", "/nobody", "--camera", CAMERA_NAME
    )


def test_ctrl_c_before_any_image_says_what_is_missing(headset: Headset, tmp_path: Path) -> None:
    stopping = threading.Event()
    stopping.set()
    with pytest.raises(EvaluationError, match="no images with camera_info of world_left"):
        record_live(PREFIX, CAMERA_NAME, tmp_path, stopping, lambda _: None)

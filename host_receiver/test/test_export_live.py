"""`export --kalibr` of a running receiver, here of nodes that publish what one would."""

import json
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import rclpy
import yaml
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import CameraInfo, CompressedImage, Imu
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from camera_messages import camera_info, stamped, transform_of
from ml2_receiver.cli import main
from ml2_receiver.configuration.mounts import save_mounts
from ml2_receiver.ros.context import end_node
from test_export_euroc import MOUNT, OPTIONS
from waiting import LIMIT_S

PREFIX = "/export_test"
CAMERAS = ("world_left", "world_right")
BASELINE_M = 0.15
LENS = (0.1, -0.02, 3e-3, -4e-4)
MATRIX = (500.0, 0.0, 320.0, 0.0, 500.0, 240.0, 0.0, 0.0, 1.0)
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class RigHeadset:
    """Two cameras on a head, and a robot whose node has static transforms of its own."""

    def __init__(self, arguments: list[str]) -> None:
        self._context = Context()
        rclpy.init(args=["headset", *arguments], context=self._context)
        self._headset: Node = rclpy.create_node("headset", context=self._context)
        self._robot: Node = rclpy.create_node("robot", context=self._context)
        # Publishers that go end what they said for all later subscribers, so they are kept.
        self._latched = [
            self._say_config(),
            self._stand(self._headset, "head_frame", "world_left_optical_frame", 0.0),
            self._stand(self._robot, "base_link", "lidar", 1.0),
            self._stand(self._headset, "head_frame", "world_right_optical_frame", BASELINE_M),
        ]
        self._heads = self._headset.create_publisher(TFMessage, "/tf", 100)
        self._infos = {
            camera: self._headset.create_publisher(CameraInfo, f"{PREFIX}/{camera}/camera_info", 5)
            for camera in CAMERAS
        }
        self._samples = self._headset.create_publisher(Imu, f"{PREFIX}/imu_left/imu", 200)
        # The headset compresses the images of one camera.
        self._images = self._headset.create_publisher(
            CompressedImage, f"{PREFIX}/world_left/image_raw/compressed", 5
        )
        self._second = 0
        self._headset.create_timer(1 / 30, self._capture)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._headset)
        self._thread = threading.Thread(target=self._executor.spin)
        self._thread.start()

    def _say_config(self) -> object:
        publisher = self._headset.create_publisher(String, f"{PREFIX}/config", _LATCHED)
        streams = {camera: {"topics": ["some"]} for camera in CAMERAS}
        publisher.publish(String(data=json.dumps({"streams": streams, "device_id": "one"})))
        return publisher

    def _stand(self, node: Node, parent: str, child: str, x: float) -> object:
        publisher = node.create_publisher(TFMessage, "/tf_static", _LATCHED)
        publisher.publish(TFMessage(transforms=[transform_of(stamped(parent), child, (x, 0, 0))]))
        return publisher

    def _capture(self) -> None:
        self._second += 1
        world = stamped("magicleap_world", self._second * 10**9)
        head = transform_of(world, "head_frame", (3, 0, 0))
        self._heads.publish(TFMessage(transforms=[head]))
        self._samples.publish(Imu(header=world))
        for camera, publisher in self._infos.items():
            frame = stamped(f"{camera}_optical_frame")
            publisher.publish(camera_info(frame, (640, 480), "equidistant", LENS, MATRIX))

    def close(self) -> None:
        self._executor.shutdown()
        self._thread.join()
        self._robot.destroy_node()
        end_node(self._headset)


@pytest.fixture
def arguments() -> list[str]:
    """The headset's, for ROS."""
    return []


@pytest.fixture
def headset(
    ros_of_children: None, arguments: list[str], monkeypatch: pytest.MonkeyPatch
) -> Iterator[RigHeadset]:
    monkeypatch.setattr("ml2_tools.commands.export.PATIENCE_S", LIMIT_S)
    headset = RigHeadset(arguments)
    yield headset
    headset.close()


def test_two_cameras_of_a_rig_are_where_tf_static_has_them(
    headset: RigHeadset, tmp_path: Path
) -> None:
    assert main(["export", "--kalibr", str(tmp_path), "--prefix", PREFIX]) == 0
    chain = yaml.safe_load((tmp_path / "camchain.yaml").read_text())
    right_of_left = np.array(chain["cam1"]["T_cn_cnm1"]) @ [0, 0, 0, 1]
    assert right_of_left == pytest.approx([-BASELINE_M, 0, 0, 1])
    assert chain["cam0"]["rostopic"] == f"{PREFIX}/world_left/image_raw/compressed"
    assert chain["cam1"]["rostopic"] == f"{PREFIX}/world_right/image_raw"


@pytest.mark.parametrize(
    ("arguments", "tools"),
    [
        (
            ["--ros-args", "-r", "/tf:=/robot1/tf", "-r", "/tf_static:=/robot1/tf_static"],
            ["-r", "/tf:=tf", "-r", "/tf_static:=tf_static", "-r", "__ns:=/robot1"],
        ),
        (
            ["--ros-args", "-r", f"{PREFIX}/world_left/image_raw/compressed:=/elsewhere"],
            ["-r", f"{PREFIX}/world_left/image_raw/compressed:=/elsewhere"],
        ),
    ],
)
def test_remapped_topics_are_followed(
    headset: RigHeadset, tmp_path: Path, tools: list[str]
) -> None:
    given = ["--ros-args", *tools]
    assert main(["export", "--kalibr", str(tmp_path), "--prefix", PREFIX, *given]) == 0
    chain = yaml.safe_load((tmp_path / "camchain.yaml").read_text())
    assert np.array(chain["cam1"]["T_cn_cnm1"])[0, 3] == pytest.approx(-BASELINE_M)
    assert chain["cam0"]["rostopic"].endswith("/compressed")


@pytest.mark.parametrize("cameras", [CAMERAS, CAMERAS[1:]])
def test_a_calibrated_imu_of_a_running_headset_is_exported(
    cameras: tuple[str, ...],
    headset: RigHeadset,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "home"))
    save_mounts({"one": {"imu_left": MOUNT}})
    words = ["--prefix", PREFIX, "--imu", "imu_left", *OPTIONS, "--cameras", *cameras]
    assert main(["export", "--kalibr", str(tmp_path / "out"), *words]) == 0
    chain = yaml.safe_load((tmp_path / "out/camchain.yaml").read_text())
    for number, camera in enumerate(cameras):
        camera_of_imu = np.array(chain[f"cam{number}"]["T_cam_imu"]) @ [0, 0, 0, 1]
        place = np.subtract(MOUNT.translation_m, (BASELINE_M * CAMERAS.index(camera), 0, 0))
        assert camera_of_imu == pytest.approx([*place, 1])

"""The 3D view of `ml2-receiver view`: what becomes of poses, lenses and depth."""

import json
import math
import time
from typing import Any

import cv2
import numpy as np
import pytest

pytest.importorskip("rclpy", reason="rclpy is not installed")

from geometry_msgs.msg import Pose, PoseArray, PoseStamped, Vector3
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import BoundingBox3D, Detection3D, Detection3DArray

from camera_messages import camera_info, stamped, transform_of
from ml2_tools.geometry.other_frames import OtherFrames
from ml2_tools.viewing.cloud import Cloud, points_in_world
from ml2_tools.viewing.newest_image import NewestImage
from ml2_tools.viewing.scene import Scene

WORLD = "magicleap_world"
DEPTH = "depth_optical_frame"
# x right, y down, z forward, of a camera that looks along the world's x axis
LOOKS_AHEAD = (-0.5, 0.5, -0.5, 0.5)
TF, HANDS = "tf2_msgs/msg/TFMessage", "geometry_msgs/msg/PoseArray"
MARKERS = "vision_msgs/msg/Detection3DArray"
INFO, IMAGE = "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/Image"


def transform(parent: str, child: str, place: Any, rotation: Any = (0, 0, 0, 1)) -> Any:
    return transform_of(stamped(parent, 7 * 10**9), child, place, rotation)


def take_transforms(scene: Scene, topic: str, *transforms: Any, at_s: float = 100) -> None:
    scene.take(topic, TF, serialize_message(TFMessage(transforms=transforms)), at_s)


def take_lens(scene: Scene, stream: str, width: int, height: int, focal: float) -> None:
    matrix = (focal, 0, width / 2, 0, focal, height / 2, 0, 0, 1)
    info = camera_info(stamped(""), (width, height), "plumb_bob", [0.0] * 5, matrix)
    scene.take(f"lens {stream}", INFO, serialize_message(info), 100)


def shown(scene: Scene, now_s: float = 100) -> Any:
    return json.loads(scene.newest(now_s)[1])


def test_head_and_cameras_are_matrices_column_by_column() -> None:
    scene = Scene("")
    take_lens(scene, "depth", 4, 4, 2.0)
    head = transform(WORLD, "head_frame", (1, 2, 3))
    take_transforms(scene, "/tf", head, transform(WORLD, DEPTH, (1, 0, 0), LOOKS_AHEAD))
    found = shown(scene)
    assert found["head"] == [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]
    pose = found["cameras"]["depth"]["pose"]
    assert pose[8:11] == pytest.approx([1, 0, 0], abs=1e-4)
    assert pose[12:15] == [1, 0, 0]


def test_cameras_of_a_rig_move_with_the_head_of_a_named_receiver() -> None:
    scene = Scene("robot1")
    take_lens(scene, "depth", 4, 4, 2.0)
    mounting = transform("robot1/head_frame", f"robot1/{DEPTH}", (0.5, 0, 0))
    take_transforms(scene, "/tf_static", mounting)
    take_transforms(scene, "/tf", transform(f"robot1/{WORLD}", "robot1/head_frame", (1, 0, 0)))
    assert shown(scene)["cameras"]["depth"]["pose"][12:15] == [1.5, 0, 0]


def test_the_parent_of_each_frame_is_told() -> None:
    # A frame that is not published any more is not in the tree; a static frame stays.
    for now_s, passing in ((100, {"head_frame": WORLD}), (200, {})):
        scene = Scene("")
        take_transforms(scene, "/tf_static", transform("head_frame", "tag", (0, 0, 1)), at_s=1)
        take_transforms(scene, "/tf", transform(WORLD, "head_frame", (1, 2, 3)))
        assert shown(scene, now_s)["parents"] == {"tag": "head_frame", **passing}


def test_the_corners_of_a_lens_are_directions() -> None:
    scene = Scene("")
    take_lens(scene, "depth", 4, 4, 2.0)
    take_transforms(scene, "/tf", transform(WORLD, DEPTH, (0, 0, 0)))
    third = 3**-0.5
    expected = [(-third, -third), (third, -third), (third, third), (-third, third)]
    corners = shown(scene)["cameras"]["depth"]["corners"]
    assert corners == [pytest.approx([x, y, third], abs=1e-4) for x, y in expected]


def test_an_untracked_joint_has_no_place() -> None:
    scene = Scene("")
    tracked, lost = Pose(), Pose()
    tracked.position.x, lost.position.y = 0.25, float("nan")
    poses = PoseArray(poses=[tracked, lost])
    scene.take("hand_left", HANDS, serialize_message(poses), 100)
    assert shown(scene)["hands"] == {"hand_left": [[0.25, 0, 0], None]}


def test_markers_have_their_sides_while_they_come() -> None:
    scene = Scene("")
    box = BoundingBox3D(size=Vector3(x=0.16, y=0.16))
    seen = Detection3DArray(detections=[Detection3D(id="tag36h11:7", bbox=box)])
    scene.take("markers", MARKERS, serialize_message(seen), 100)
    take_transforms(scene, "/tf", transform(WORLD, "tag36h11:7", (1, 0, 0)))
    assert shown(scene)["markers"] == {"tag36h11:7": 0.16}
    assert shown(scene)["frames"].keys() == {"tag36h11:7"}
    row = {"stream": "markers", "type": MARKERS}
    assert scene.topics({"/magic_leap2/markers": row}, ())["markers"][1] == MARKERS


def test_a_tag_in_the_image_of_a_camera_is_where_the_camera_sees_it() -> None:
    scene = Scene("robot1")
    depth = f"robot1/{DEPTH}"
    take_transforms(scene, "/tf", transform(f"robot1/{WORLD}", depth, (1, 0, 0), LOOKS_AHEAD))
    take_transforms(scene, "/tf", transform(depth, "tag36h11:3", (0, 0, 2)))
    found = shown(scene)["frames"]
    assert found.keys() == {"tag36h11:3"}
    assert found["tag36h11:3"][12:15] == pytest.approx([3, 0, 0], abs=1e-4)


def test_a_robot_whose_map_is_the_parent_of_the_world_is_shown() -> None:
    scene = Scene("")
    take_transforms(scene, "/tf_static", transform("map", WORLD, (1, 0, 0)))
    take_transforms(scene, "/tf", transform("map", "base_link", (5, 2, 0)))
    found = shown(scene)["frames"]
    assert {name: it[12:15] for name, it in found.items()} == {
        "map": [-1, 0, 0],
        "base_link": [4, 2, 0],
    }


def test_frames_that_nothing_attaches_to_the_world_are_not_shown() -> None:
    scene = Scene("")
    circle = transform("here", "there", (1, 0, 0)), transform("there", "here", (1, 0, 0))
    own = transform(WORLD, "head_frame", (1, 2, 3)), transform("head_frame", DEPTH, (0, 0, 0))
    take_transforms(scene, "/tf_static", *circle, own[1])
    take_transforms(scene, "/tf", *circle, own[0], transform("odom", "base_link", (1, 0, 0)))
    assert shown(scene)["frames"] == {}


def test_other_frames_that_stop_coming_vanish_and_static_ones_stay() -> None:
    frames = OtherFrames(WORLD, [])
    frames.take(TFMessage(transforms=[transform(WORLD, "table", (1, 0, 0))]), math.inf)
    frames.take(TFMessage(transforms=[transform(WORLD, "tag", (1, 0, 0))]), 101)
    assert frames.poses({}, 101).keys() == {"table", "tag"}
    assert frames.poses({}, 101.1).keys() == {"table"}
    frames.take(TFMessage(transforms=[transform(WORLD, "cup", (1, 0, 0))]), 200)
    frames.forget()
    assert frames.poses({}, 101.1).keys() == {"table"}


def test_of_endless_frames_the_first_are_shown() -> None:
    frames = OtherFrames(WORLD, [])
    many = [transform(WORLD, f"frame{number}", (1, 0, 0)) for number in range(300)]
    frames.take(TFMessage(transforms=many), 101)
    assert len(frames.poses({}, 100)) == 200
    frames.take(TFMessage(transforms=[transform(WORLD, "late", (1, 0, 0))]), 201)
    assert frames.poses({}, 200) == {}
    frames.take(TFMessage(transforms=[transform(WORLD, "late", (1, 0, 0))]), 201)
    assert frames.poses({}, 200).keys() == {"late"}


def test_invalid_messages_are_ignored() -> None:
    scene = Scene("")
    scene.take("/tf", TF, b"\x00\x01\x00\x00\xff\xff\xff\xff", 100)
    scene.take("gaze", "geometry_msgs/msg/PoseStamped", serialize_message(zero_rotation()), 100)
    scene.take("lens depth", INFO, serialize_message(CameraInfo()), 100)
    found = shown(scene)
    assert (found["head"], found["gaze"], found["cameras"]) == (None, None, {})


def zero_rotation() -> Any:
    found = PoseStamped()
    found.pose.orientation.w = 0.0
    return found


def test_what_does_not_come_any_more_is_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now_s[0])
    scene = Scene("")
    take_transforms(scene, "/tf", transform(WORLD, "head_frame", (1, 2, 3)))
    assert shown(scene)["head"] is not None
    now_s[0] += 0.1
    assert shown(scene, 101.1)["head"] is None


def test_what_is_forgotten_may_come_from_an_earlier_time(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now_s[0])
    scene = Scene("")
    take_hand(scene, 1, 100)
    take_transforms(scene, "/tf", transform(WORLD, "head_frame", (1, 2, 3)))
    scene.forget()
    assert shown(scene, 50)["head"] is None
    take_hand(scene, 2, 50)
    now_s[0] += 0.1
    assert shown(scene, 50)["hands"] == {"hand_left": [[2, 0, 0]]}


def take_hand(scene: Scene, metres: float, at_s: float) -> None:
    joint = Pose()
    joint.position.x = float(metres)
    scene.take("hand_left", HANDS, serialize_message(PoseArray(poses=[joint])), at_s)


def test_there_are_15_scenes_per_second_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now_s[0])
    scene = Scene("")
    numbers = set()
    for step in range(100):
        now_s[0] += 0.01
        head = transform(WORLD, "head_frame", (step, 0, 0))
        take_transforms(scene, "/tf", head, at_s=now_s[0])
        numbers.add(scene.newest(now_s[0])[0])
    assert 13 <= len(numbers) <= 16


def test_hands_are_decoded_20_times_per_second_at_most(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now_s[0])
    scene = Scene("")
    places = set()
    for step in range(60):
        take_hand(scene, step, now_s[0])
        now_s[0] += 1 / 60
        places.add(shown(scene, now_s[0])["hands"]["hand_left"][0][0])
    assert 13 <= len(places) <= 20


def test_camera_info_is_subscribed_to_with_the_image_only() -> None:
    stream = {"type": IMAGE, "stream": "depth"}
    rows = {
        "session": {"state.depth": "running"},
        "/p/depth/image_raw": stream,
        "/p/depth/camera_info": stream | {"type": INFO},
        "/p/gaze": {"type": "geometry_msgs/msg/PoseStamped", "stream": "gaze"},
    }
    scene = Scene("")
    assert scene.topics(rows, {"scene"}).keys() == {"/tf", "/tf_static", "gaze"}
    assert scene.topics(rows, {"scene", "depth"})["lens depth"] == ("/p/depth/camera_info", INFO)


def depth_image(pixels: Any) -> NewestImage:
    height, width = pixels.shape
    data = pixels.astype("<f4").tobytes()
    image = Image(height=height, width=width, step=4 * width, encoding="32FC1", data=data)
    image.header.stamp.sec = 7
    found = NewestImage("depth")
    assert found.take(IMAGE, serialize_message(image))
    return found


def test_depth_becomes_points_in_the_world() -> None:
    scene = Scene("")
    cloud = Cloud(scene)
    pixels = np.full((480, 544), 2.0)
    pixels[:240] = np.nan
    take_lens(scene, "depth", 544, 480, 400.0)
    take_transforms(scene, "/tf", transform(WORLD, DEPTH, (1, 0, 0.5), LOOKS_AHEAD))
    number, message = cloud.encoded(depth_image(pixels), NewestImage("color"))
    assert (number, message[:6]) == (1, b"\x05cloud")
    points = np.frombuffer(message, "<f4", offset=10).reshape(-1, 3)
    assert 1000 < len(points) <= 2500
    assert points[:, 0] == pytest.approx(3, abs=1e-5)
    # The lower half of the image is below the camera; its left is the world's +y.
    assert points[:, 2].max() == pytest.approx(0.5, abs=0.1)
    assert points[:, 1].max() == pytest.approx(2 * 272 / 400, abs=0.1)


def test_points_have_the_colours_of_the_rgb_image_where_it_sees_them() -> None:
    scene = Scene("")
    for stream in ("depth", "color"):
        take_lens(scene, stream, 40, 40, 40.0)
        frame = f"{stream}_optical_frame"
        take_transforms(scene, "/tf", transform(WORLD, frame, (0, 0, 0), LOOKS_AHEAD))
    # In the order blue, green, red: the left half is red, the right half is green.
    bgr = np.zeros((40, 40, 3), np.uint8)
    bgr[:, :20, 2], bgr[:, 20:, 1] = 200, 100
    data = cv2.imencode(".jpg", bgr, (cv2.IMWRITE_JPEG_QUALITY, 100))[1].tobytes()
    jpeg = CompressedImage(format="bgr8; jpeg compressed bgr8", data=data)
    jpeg.header.stamp.sec = 7
    color = NewestImage("color")
    color.take("sensor_msgs/msg/CompressedImage", serialize_message(jpeg))
    depth = depth_image(np.full((40, 40), 2.0))
    points = points_in_world(scene, depth.newest, color.newest, 1600)
    assert points is not None
    assert points.colours is not None
    # The world's +y is left. Near the edge, JPEG mixes the colours.
    left, right = points.places[:, 1] > 0.5, points.places[:, 1] < -0.5
    assert points.colours[left] == pytest.approx(np.tile([200, 0, 0], (int(left.sum()), 1)), abs=12)
    assert points.colours[right] == pytest.approx(
        np.tile([0, 100, 0], (int(right.sum()), 1)), abs=12
    )
    _, message = Cloud(scene).encoded(depth, color)
    assert len(message) == 10 + 1600 * (12 + 3)


def test_depth_without_a_pose_or_a_lens_makes_no_points() -> None:
    scene = Scene("")
    assert Cloud(scene).encoded(depth_image(np.ones((4, 4))), NewestImage("color"))[0] == 0
    take_lens(scene, "depth", 4, 4, 2.0)
    assert Cloud(scene).encoded(depth_image(np.ones((4, 4))), NewestImage("color"))[0] == 0
    assert Cloud(scene).encoded(NewestImage("depth"), NewestImage("color"))[0] == 0

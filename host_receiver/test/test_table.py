import re
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
import yaml

from ml2_receiver.errors import TableError
from ml2_receiver.table.reader import load_table, read_table
from ml2_receiver.wire.kinds import Lane, LaneKind
from promised_topics import ALL_OTHERS, INFRA, MIXED_REALITY

ROOT = Path(__file__).resolve().parents[2]

IMAGE, CAMERA_INFO, STRING = (
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CameraInfo",
    "std_msgs/msg/String",
)
COMPRESSED, IMU = "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/Imu"
VIDEO = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket"
FOXGLOVE = "foxglove_msgs/msg/CompressedVideo"
IMAGES = (IMAGE, COMPRESSED, VIDEO, FOXGLOVE)
POSE = "geometry_msgs/msg/PoseStamped"


def camera(name: str, image: str, type: str) -> dict[str, str]:
    return {
        f"{name}/{image}": type,
        f"{name}/camera_info": CAMERA_INFO,
        f"{name}/metadata": STRING,
    }


# Written down from the specification, not from the table.
TOPICS = {
    **camera("world_center", "image_raw", IMAGE),
    **camera("world_left", "image_raw", IMAGE),
    **camera("world_right", "image_raw", IMAGE),
    **camera("color", "image_raw/compressed", COMPRESSED),
    **camera("mixed_reality", "image_raw/compressed", COMPRESSED),
    **camera("depth", "image_raw", IMAGE),
    "depth/image_raw/compressedDepth": COMPRESSED,
    **{f"world_{it}/image_raw/compressed": COMPRESSED for it in ("center", "left", "right")},
    **{f"world_{it}/image_raw/ffmpeg": VIDEO for it in ("center", "left", "right")},
    **{f"{it}/image_raw/ffmpeg": VIDEO for it in ("color", "mixed_reality")},
    **{f"world_{it}/image_raw/foxglove": FOXGLOVE for it in ("center", "left", "right")},
    **{f"{it}/image_raw/foxglove": FOXGLOVE for it in ("color", "mixed_reality")},
    **camera("infra", "image_raw", IMAGE),
    "depth/confidence": IMAGE,
    "depth/flags": IMAGE,
    **{f"eye_{place}/image_raw": IMAGE for place in ("nasal_left", "nasal_right")},
    **{f"eye_{place}/image_raw": IMAGE for place in ("temple_left", "temple_right")},
    **{f"eye_{it}/image_raw/compressed": COMPRESSED for it in ("nasal_left", "nasal_right")},
    **{f"eye_{it}/image_raw/compressed": COMPRESSED for it in ("temple_left", "temple_right")},
    **{f"eye_{place}/metadata": STRING for place in ("nasal_left", "nasal_right")},
    **{f"eye_{place}/metadata": STRING for place in ("temple_left", "temple_right")},
    **{
        f"{sensor}_{place}/imu": IMU
        for sensor in ("accel", "gyro", "imu")
        for place in ("left", "right", "compute_pack")
    },
    "light_sensor": "sensor_msgs/msg/Illuminance",
    "head_pose": POSE,
    "magnetometer_left": "sensor_msgs/msg/MagneticField",
    "magnetometer_right": "sensor_msgs/msg/MagneticField",
    "pressure_headset": "sensor_msgs/msg/FluidPressure",
    "pressure_compute_pack": "sensor_msgs/msg/FluidPressure",
    "gaze": POSE,
    "hand_left": "geometry_msgs/msg/PoseArray",
    "hand_right": "geometry_msgs/msg/PoseArray",
    "controller": POSE,
    "controller/joy": "sensor_msgs/msg/Joy",
    "map/state": "diagnostic_msgs/msg/DiagnosticArray",
    "battery": "sensor_msgs/msg/BatteryState",
    "markers": "vision_msgs/msg/Detection3DArray",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
}


def test_it_has_every_topic_of_the_specification_with_its_type() -> None:
    topics = [topic for stream in load_table().streams.values() for topic in stream.topics]
    assert {topic.name: topic.type for topic in topics} == TOPICS
    assert len(topics) == len(TOPICS)


def test_a_sensor_of_android_is_in_every_file_that_lists_it() -> None:
    """The files of docs/add_a_sensor.md. Inertial units are listed by their places there."""
    main = "main/kotlin/dev/ml2sensors"
    lists = (
        f"ml2-sensors-aar/src/{main}/android/SensorRow.kt",
        f"ml2-sensors-aar/simulator/src/{main}/simulator/simulated/SensorManagerSignals.kt",
    )
    streams = [it for it in load_table().streams.values() if "sensor_manager" in it.backends]
    names = {
        re.sub(r"_(\w)", lambda it: it[1].upper(), stream.id)
        for stream in streams
        if stream.topics[0].type != IMU
    }
    assert names
    forgotten = [
        f"{file}: {name}"
        for file in lists
        for name in names
        if f"StreamTable.{name}" not in (ROOT / file).read_text()
    ]
    promised = ALL_OTHERS.keys() | MIXED_REALITY.keys() | INFRA.keys() | {"/tf"}
    first = [it.topics[0].name for it in load_table().streams.values() if it.topics]
    forgotten += [f"promised_topics.py: {it}" for it in first if it not in promised]
    assert forgotten == []


def test_only_images_have_a_lane_of_their_own() -> None:
    table = load_table()
    for stream in table.streams.values():
        for topic in stream.topics:
            is_image = topic.type in IMAGES
            assert topic.lane.name == (stream.id if is_image else "sensors"), topic
            assert topic.lane.is_urgent is not is_image
            assert topic.lane.max_payload_bytes == (16 << 20 if is_image else 64 << 10)
    assert len(table.lanes) == 13  # with custom, for large messages of an app
    assert table.needed_lanes == ("time", "sensors")


def test_large_messages_that_are_no_images_have_a_lane_for_each_stream() -> None:
    document = packaged()
    document["kinds"]["poses"][0]["lane"] = "bulk"
    table = read_table(document)
    left, right = (table.streams[f"hand_{side}"].topics[0].lane for side in ("left", "right"))
    assert (left, right) == (table.lanes["hand_left"], table.lanes["hand_right"])
    assert left == Lane("hand_left", LaneKind.BULK, is_urgent=False, max_payload_bytes=16 << 20)
    assert table.streams["hand_left"].images == ()


def test_only_the_table_says_whose_images_show_eyes() -> None:
    """As SECURITY.md has it: exactly those that need the permission for eye cameras."""
    sections = load_table().sections.values()
    shown = {it.id for it in sections if it.shows_eyes}
    permission = "com.magicleap.permission.EYE_CAMERA"
    assert shown == {it.id for it in sections if permission in it.permissions}
    assert len(shown) == 4


def test_queue_depths_follow_the_kind_of_message() -> None:
    table = load_table()
    depths = {**dict.fromkeys(IMAGES, 5), CAMERA_INFO: 5, STRING: 5, IMU: 200}
    depths["tf2_msgs/msg/TFMessage"] = 100
    for stream in table.streams.values():
        for topic in stream.topics:
            if topic.name == "/tf_static":
                continue
            assert table.qos[topic.qos].depth == depths.get(topic.type, 10), topic
            assert table.qos[topic.qos].durability == "volatile"


def test_the_applied_configuration_is_kept_for_late_subscribers() -> None:
    table = load_table()
    config = next(topic for topic in table.receiver_topics if topic.name == "config")
    assert table.qos[config.qos].durability == "transient_local"
    assert table.qos[config.qos].depth == 1


def test_static_transforms_are_kept_for_late_subscribers_and_are_the_rigs_alone() -> None:
    table = load_table()
    _, static = table.streams["tf"].topics
    assert table.qos[static.qos].durability == "transient_local"
    assert table.qos[static.qos].depth == 1
    assert static.when is not None
    assert static.when.holds({"layout": "rig"})
    assert not static.when.holds({"layout": "flat"})


def test_encodings_are_those_of_the_image_topics() -> None:
    encodings = {
        topic.name: topic.encoding
        for stream in load_table().streams.values()
        for topic in stream.topics
        if topic.encoding
    }
    assert encodings["world_left/image_raw"] == "mono8"
    assert encodings["color/image_raw/compressed"] == "rgb8; jpeg compressed bgr8"
    assert encodings["depth/image_raw"] == encodings["depth/confidence"] == "32FC1"
    assert encodings["depth/flags"] == "32SC1"
    assert encodings["world_left/image_raw/compressed"] == "mono8; jpeg compressed mono8"
    assert encodings["depth/image_raw/compressedDepth"] == "16UC1; compressedDepth rvl"
    assert encodings["world_left/image_raw/ffmpeg"] == "h264;yuv420p;mono8;mono8"
    assert encodings["color/image_raw/ffmpeg"] == "h264;yuv420p;bgr8;bgr8"
    assert len(encodings) == 31


def test_each_format_of_a_camera_has_one_image_topic() -> None:
    table = load_table()
    for stream in table.streams.values():
        legal = {format for mode in table.sections[stream.section].modes for format in mode.formats}
        for format in (stream.when or {}).get("format", legal):
            images = [it for it in stream.topics if it.role == "image"]
            published = [
                it for it in images if it.when is None or it.when.holds({"format": format})
            ]
            assert len(published) == 1, (stream.id, format)


def test_a_global_topic_has_no_prefix() -> None:
    streams = load_table().streams
    assert streams["tf"].topics[0].full_name("/lab") == "/tf"
    assert streams["gaze"].topics[0].full_name("/lab") == "/lab/gaze"


def test_the_table_cannot_be_changed() -> None:
    with pytest.raises(TypeError):
        load_table().streams["tf"] = load_table().streams["gaze"]  # type: ignore[index]


def packaged() -> Any:
    """The document that is read as the table."""
    text = resources.files("ml2_receiver").joinpath("data/streams.yaml").read_text("utf-8")
    return yaml.safe_load(text)


def row(*path: str | int) -> Callable[[Any], Any]:
    def find(document: Any) -> Any:
        for name in path:
            document = document[name]
        return document

    return find


@pytest.mark.parametrize(
    ("find", "key", "value", "message"),
    [
        (row(), "schema", 2, "schema: expected one of 1, found 2"),
        (row("streams", "gaze"), "section", "eyes", r"gaze: section: .*hands.*found eyes"),
        (row("streams", "gaze"), "kind", "ray", r"gaze: kind: .*poses.*found ray"),
        (row("streams", "gaze"), "topic", "head_pose", "more than one stream: head_pose"),
        (row("streams", "gaze"), "when", {"on": True}, "gaze: when: .*enabled.*found on"),
        (row("streams", "gaze"), "values", ["imu.x"], "gaze: values: .*united.*found x"),
        (row("kinds", "imu"), 0, {"role": "imu"}, "accel_left: 'lane' is missing"),
        (row("sections", "gaze"), "permissions", ["GAZE"], "gaze: permission: .*found GAZE"),
        (row("permissions"), "android.permission.CAMERA", "high", "protection: .*found high"),
        (row("qos", "imu"), "dept", 3, "imu: .*dept"),
        (row("lanes", "bulk"), "is_slow", True, "bulk: .*is_slow"),
        (row("lanes"), "maps", packaged()["lanes"]["bulk"], "maps: the wire knows no lanes"),
        (row("kinds", "jpeg_camera", 3), "lane", "bulk", "lane color: .*one class"),
        (row("paces", "imu"), "longest_pause_s", 0, "accel_left: longest_pause_s: .*found 0"),
        (row("paces", "imu"), "rate_hz", 0, "accel_left: rate_hz: .*found 0"),
        (row("paces"), "imu", {"pause_s": 2}, "accel_left: .*pause_s"),
        (row("sections", "tf", "keys", "layout"), "default", "x", "layout: default: .*found x"),
        (row("sections", "gaze", "keys", "enabled"), "type", "yes", "enabled: type: .*found yes"),
        (row("sections", "world_left", "defaults"), "update_rate", 60, "world_.*: defaults: "),
    ],
)
def test_a_contradiction_is_reported_with_its_place(
    find: Callable[[Any], Any], key: Any, value: Any, message: str
) -> None:
    document = packaged()
    read_table(document)
    find(document)[key] = value
    with pytest.raises(TableError) as raised:
        read_table(document)
    assert re.search(message, str(raised.value)), raised.value


def test_a_kind_without_a_pace_is_reported() -> None:
    document = packaged()
    del document["paces"]["imu"]
    with pytest.raises(TableError, match=r"accel_left: kind under paces: expected .*found imu"):
        read_table(document)


@pytest.mark.parametrize(
    ("name", "value"),
    [("lane", "nothing"), ("qos", "nothing"), ("type", "nothing"), ("when", {"nothing": True})],
)
def test_a_topic_that_names_what_does_not_exist_is_reported(name: str, value: object) -> None:
    document = packaged()
    document["kinds"]["battery"][0][name] = value
    with pytest.raises(TableError, match=f"battery: {name}: .*nothing"):
        read_table(document)

"""The RViz configuration of a receiver."""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from command_line import refusal
from configurations import only
from ml2_receiver.cli import main
from ml2_receiver.table.reader import load_table
from ml2_tools.products.product import Shared, all_products

TABLE = load_table()
MADE = {topic: type for it in all_products(Shared()) for topic, type in it.types.items()}
SENT = {topic.name: topic.type for it in TABLE.streams.values() for topic in it.topics}
# The types that RViz's own displays show; an Image takes the transport from the topic's name.
TYPES = {
    "rviz_default_plugins/Image": {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"},
    "rviz_default_plugins/PointCloud2": {"sensor_msgs/msg/PointCloud2"},
    "rviz_default_plugins/Pose": {"geometry_msgs/msg/PoseStamped"},
    "rviz_default_plugins/PoseArray": {"geometry_msgs/msg/PoseArray"},
}


CONFIG = only(
    """
    world_left: {enabled: true},
    world_right: {enabled: true, format: h264},
    depth_center: {enabled: true, format: depth16, confidence: true},
    hands: {enabled: true},
    """
)


def written(folder: Path, *options: str) -> Any:
    file = folder / "my.rviz"
    assert main(["rviz", "--out", str(file), *options]) == 0
    return yaml.safe_load(file.read_text())["Visualization Manager"]


def shown(manager: Any, *, is_on: bool = False) -> dict[str, str]:
    """The class of the display of each topic."""
    displays = [it for it in manager["Displays"] if "Topic" in it and it["Enabled"] >= is_on]
    return {it["Topic"]["Value"]: it["Class"] for it in displays}


def needs(text: str) -> dict[str, str]:
    """Returns the words about each display, by its name."""
    return dict(re.split(r" +needs | +(?=is on)", it) for it in text.splitlines()[3:])


def test_it_shows_topics_and_frames_of_the_named_receiver(tmp_path: Path) -> None:
    manager = written(tmp_path, "--name", "robot1", "--prefix", "/head")
    assert manager["Global Options"]["Fixed Frame"] == f"robot1/{TABLE.world_frame}"
    assert manager["Views"]["Current"]["Target Frame"] == f"robot1/{TABLE.head_frame}"
    assert all(topic.startswith("/robot1/head/") for topic in shown(manager))


def test_each_topic_is_one_that_is_sent_or_made_and_that_rviz_shows(tmp_path: Path) -> None:
    manager = written(tmp_path)
    assert manager["Global Options"]["Fixed Frame"] == TABLE.world_frame
    for topic, display in shown(manager).items():
        assert (SENT | MADE)[topic.removeprefix("/magic_leap2/")] in TYPES[display]


def test_what_a_new_user_has_is_seen_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    topic = "/magic_leap2/world_center/image_raw/compressed"
    assert shown(written(tmp_path), is_on=True) == {topic: "rviz_default_plugins/Image"}
    assert needs(capsys.readouterr().out)["world_center"] == "is on"


def test_displays_are_on_for_what_the_configuration_publishes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "my.yaml").write_text(CONFIG)
    manager = written(tmp_path, "--config", str(tmp_path / "my.yaml"), "--name", "robot1")
    on = [it.removeprefix("/robot1/magic_leap2/") for it in shown(manager, is_on=True)]
    depth = "depth/image_raw/compressedDepth"
    assert on == ["world_left/image_raw", depth, "depth/confidence", "hand_left", "hand_right"]
    (display,) = (it for it in manager["Displays"] if it["Name"] == "depth")
    assert display["Max Value"] == 5000  # mm, as depth16 has them
    said = needs(capsys.readouterr().out)
    assert said.keys() == {it["Name"] for it in manager["Displays"]} - {"Grid"}
    assert said["world_center"] == "world_center.enabled=true"
    assert said["world_right"] == "world_right.format=Grayscale"
    assert said["mixed_reality"] == "picture_center.enabled=true picture_center.stream=1"
    assert said["infra"] == "depth_center.format=DepthRaw"
    assert said["depth/points"] == "`ml2-receiver products --name robot1`"


def test_a_file_that_is_there_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "mine.rviz"
    file.write_text("precious")
    assert "exists already" in refusal("rviz", "--out", file)
    assert file.read_text() == "precious"

"""The RViz configuration of a receiver."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from ml2_receiver.cli import main
from ml2_receiver.table.reader import load_table
from ml2_tools.products.product import Shared, all_products
from refusals import refusal

TABLE = load_table()
MADE = {topic: type for it in all_products(Shared()) for topic, type in it.types.items()}
SENT = {topic.name: topic.type for it in TABLE.streams.values() for topic in it.topics}
# What each display of RViz's own plugins shows; an Image takes the transport from the topic's name.
TYPES = {
    "rviz_default_plugins/Image": {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"},
    "rviz_default_plugins/PointCloud2": {"sensor_msgs/msg/PointCloud2"},
}


def written(folder: Path, *options: str) -> Any:
    file = folder / "my.rviz"
    assert main(["rviz", "--out", str(file), *options]) == 0
    return yaml.safe_load(file.read_text())["Visualization Manager"]


def shown(manager: Any) -> dict[str, str]:
    """The class of the display of each topic."""
    return {it["Topic"]["Value"]: it["Class"] for it in manager["Displays"] if "Topic" in it}


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


def test_what_each_display_needs_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    manager = written(tmp_path, "--name", "robot1")
    said = dict(
        line.split(" needs ") for line in capsys.readouterr().out.splitlines() if " needs " in line
    )
    said = {display.strip(): needs for display, needs in said.items()}
    assert said.keys() == {it["Name"] for it in manager["Displays"]} - {"Grid"}
    products = " and `ml2-receiver products --name robot1`"
    assert said["Depth points"] == f"depth_center.enabled=true{products}"
    needed_in = "with the format {} also `ml2-receiver products --name robot1`"
    assert said["World, left"] == f"world_left.enabled=true, {needed_in.format('jpeg')}"
    assert said["Depth"] == f"depth_center.enabled=true, {needed_in.format('depth16')}"
    assert said["Colour"] == "picture_center.enabled=true"
    for display in manager["Displays"]:
        topic = display.get("Topic", {"Value": ""})["Value"].split("/", 3)[-1]
        is_made = topic in MADE and topic not in SENT
        assert (products in said.get(display["Name"], "")) == is_made


def test_a_file_that_is_there_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "mine.rviz"
    file.write_text("precious")
    assert "exists already" in refusal("rviz", "--out", file)
    assert file.read_text() == "precious"

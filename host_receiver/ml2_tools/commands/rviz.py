"""ml2-receiver rviz: writes an RViz configuration for one receiver."""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from importlib import resources
from pathlib import Path
from typing import Any

import yaml

from ml2_receiver.commands.options import Subparsers, add_file, add_name
from ml2_receiver.commands.receiving import config_file, load
from ml2_receiver.configuration.config import Config
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Stream, Topic

from ..errors import ExportError

_EPILOG = """\
The displays of what the configuration publishes are on, the others are off; this also prints what
each of those needs. An existing file is not replaced, because RViz saves its layout in it.

examples:
  ml2-receiver rviz --out ml2.rviz
  ml2-receiver rviz --config my.yaml --out my.rviz      for `run --config my.yaml`
  ml2-receiver rviz --name robot1 --out robot1.rviz
"""
# The displays of RViz's own plugins. Image takes the transport from the topic's name.
_DISPLAYS = {
    "sensor_msgs/msg/Image": "Image",
    "sensor_msgs/msg/CompressedImage": "Image",
    "geometry_msgs/msg/PoseStamped": "Pose",
    "geometry_msgs/msg/PoseArray": "PoseArray",
}
_FARTHEST = {"Depth32": 5, "depth16": 5000}  # in the pixels' unit; short range ends before
_OF_COMPRESSED = "ros-jazzy-compressed-image-transport ros-jazzy-compressed-depth-image-transport"


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "rviz", help="write an RViz configuration for a receiver", epilog=_EPILOG
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="the file to write")
    add_file(parser, "--config", metavar="FILE", help="that of `run`; default: as of `run`")
    parser.add_argument("--prefix", help="default: general.topic_name of the configuration")
    add_name(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    config = load(config_file(options), options)
    if options.prefix is not None:
        config = replace(config, values={**config.values, "general.topic_name": options.prefix})
    text = resources.files("ml2_tools").joinpath("data/template.rviz").read_text("utf-8")
    rviz = yaml.safe_load(text)
    manager = rviz["Visualization Manager"]
    _address(manager, config)
    displays = list(_displays(config))
    manager["Displays"] += [display for display, _ in displays]
    try:
        with options.out.open("x", encoding="utf-8") as file:
            yaml.safe_dump(rviz, file, sort_keys=False)
    except FileExistsError as error:
        raise ExportError(f"{options.out} exists already: choose another --out") from error
    except OSError as error:
        raise ExportError(f"{options.out} cannot be written: {error.strerror}") from error
    print(f"wrote {options.out}; open it with: rviz2 -d {options.out}")
    print(f"RViz shows compressed images with: sudo apt install {_OF_COMPRESSED}\n")
    for display, needs in displays:
        print(f"{display['Name']:<16} {f'needs {needs}' if needs else 'is on'}")
    print(f"{'TF':<16} needs head tracking: somebody wears the headset, and it sees the room")
    return 0


def _address(manager: Any, config: Config) -> None:
    """Puts a receiver's frames and topics into the template."""
    table, frames = load_table(), config.frame_prefix
    manager["Global Options"]["Fixed Frame"] = frames + table.world_frame
    manager["Views"]["Current"]["Target Frame"] = frames + table.head_frame


def _displays(config: Config) -> Iterator[tuple[dict[str, Any], str]]:
    """Yields displays, each with what it needs to show something; empty if that is there."""
    for stream in load_table().streams.values():
        values = {name.rpartition(".")[2]: config.values[name] for name in stream.values}
        lacking = _lacking(stream, config)
        topics = [it for it in stream.topics if it.type in _DISPLAYS]
        sent = [it for it in topics if it.when is None or it.when.holds(values)]
        if topics and not sent:  # video, which Image does not show
            sent = topics[:1]
            lacking += [f"{stream.section}.{it.when.key}={it.when.value}" for it in sent if it.when]
        for topic in sent:
            yield _display(topic, config, is_on=not lacking), " ".join(lacking)
    depth = " ".join(_lacking(load_table().streams["depth"], config))
    products = f"`ml2-receiver products{f' --name {config.name}' if config.name else ''}`"
    points = _shown("PointCloud2", "depth/points", config, is_on=False)
    yield points, " and ".join(filter(None, [depth, products]))


def _display(topic: Topic, config: Config, *, is_on: bool) -> dict[str, Any]:
    display = _shown(_DISPLAYS[topic.type], topic.name, config, is_on=is_on)
    if topic.when is not None and topic.when.value in _FARTHEST:
        farthest = _FARTHEST[topic.when.value]
        display |= {"Normalize Range": False, "Min Value": 0, "Max Value": farthest}
    return display


def _shown(kind: str, topic: str, config: Config, *, is_on: bool) -> dict[str, Any]:
    name = topic.removesuffix("/compressed").removesuffix("/compressedDepth")
    return {
        "Class": f"rviz_default_plugins/{kind}",
        "Name": name.removesuffix("/image_raw"),
        "Enabled": is_on,
        "Value": is_on,
        "Topic": {
            "Value": f"{config.prefix}/{topic}",
            "Depth": 5,
            "Reliability Policy": "Best Effort",
        },
    }


def _lacking(stream: Stream, config: Config) -> list[str]:
    """Returns the values with which the configuration would start a stream; empty if it does."""
    legal = {f"{stream.section}.{key}": it for key, it in (stream.when or {}).items()}
    lacking = {key: it[0] for key, it in legal.items() if config.values[key] not in it}
    return [f"{key}={'true' if it is True else it}" for key, it in lacking.items()]

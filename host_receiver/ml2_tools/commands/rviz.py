"""ml2-receiver rviz: writes an RViz configuration for one receiver."""

import argparse
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import yaml

from ml2_receiver.commands.options import Subparsers, add_name
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import VIDEO

from ..errors import ExportError
from ..images.image_topic import image_topics

_EPILOG = """\
An RViz display stays empty until its topic is published, so this also prints what each display
needs. An existing file is not replaced, because RViz saves its layout in it.

examples:
  ml2-receiver rviz --out ml2.rviz
  ml2-receiver rviz --name robot1 --out robot1.rviz
"""
# `ml2-receiver products` publishes this topic.
_PRODUCT = "points"


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "rviz", help="write an RViz configuration for a receiver", epilog=_EPILOG
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="the file to write")
    parser.add_argument(
        "--prefix", default="/magic_leap2", help="general.topic_name; default: /magic_leap2"
    )
    add_name(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    text = resources.files("ml2_tools").joinpath("data/template.rviz").read_text("utf-8")
    rviz = yaml.safe_load(text)
    _address(rviz["Visualization Manager"], options.name, options.prefix)
    try:
        with options.out.open("x", encoding="utf-8") as file:
            yaml.safe_dump(rviz, file, sort_keys=False)
    except FileExistsError as error:
        raise ExportError(f"{options.out} exists already: choose another --out") from error
    except OSError as error:
        raise ExportError(f"{options.out} cannot be written: {error.strerror}") from error
    print(f"wrote {options.out}; open it with: rviz2 -d {options.out}\n")
    for display, needs in _needs(yaml.safe_load(text)["Visualization Manager"], options.name):
        print(f"{display:<14} needs {needs}")
    return 0


def _address(manager: Any, name: str, prefix: str) -> None:
    """Puts a receiver's frames and topics into the template."""
    table, frames = load_table(), f"{name}/" if name else ""
    manager["Global Options"]["Fixed Frame"] = frames + table.world_frame
    manager["Views"]["Current"]["Target Frame"] = frames + table.head_frame
    for display in manager["Displays"]:
        if "Topic" in display:
            topics = f"/{name}{prefix}" if name else prefix
            display["Topic"]["Value"] = f"{topics}/{display['Topic']['Value']}"


def _needs(manager: Any, name: str) -> Iterator[tuple[str, str]]:
    products = f"`ml2-receiver products{f' --name {name}' if name else ''}`"
    for display in manager["Displays"]:
        if "Topic" not in display:
            continue
        stream, _, rest = display["Topic"]["Value"].partition("/")
        needs = f"{load_table().streams[stream].section}.enabled=true"
        if rest == _PRODUCT:
            needs += f" and {products}"
        elif formats := _formats_without(stream, display["Topic"]["Value"]):
            needs += f", with the format {' or '.join(formats)} also {products}"
        yield display["Name"], needs
    yield "TF", "head tracking: somebody wears the headset and its cameras see the surroundings"


def _formats_without(stream: str, topic: str) -> list[str]:
    """Returns the formats of a stream with which products make an image topic that it lacks."""
    conditions = [it.when for it in image_topics(stream) if it.name != topic]
    return [str(it.value) for it in conditions if it is not None and it.value not in VIDEO]

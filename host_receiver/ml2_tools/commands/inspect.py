"""ml2-receiver inspect: whether a recording is fit to be used."""

import argparse
import json
import sys
from pathlib import Path

from rich.console import Console

from ml2_receiver.commands.config import Subparsers

from ..bags.bag_reader import Bag
from ..inspection.inspection import as_objects, inspect, worst
from ..inspection.table import integrity_table, problems
from .reading import progress

_WIDTH = 160
_EPILOG = """\
Reads any rosbag2 folder with an MCAP file, without ROS. Of each topic: messages that cannot be
read, rate, missing ones, jitter and order of stamps, and latency, which here is the time of the
recording less the stamp; of cameras also camera_info, metadata and transforms at the stamps of
images. What is "wrong" harms whoever uses the recording; a "hint" may not matter to you.

Exit code: 0, 1 when anything is "wrong", or 2 when the recording cannot be read.

examples:
  ml2-receiver inspect walk
  ml2-receiver inspect walk --json | jq '.[] | select(.verdict != "ok")'
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "inspect",
        help="look for gaps, wrong stamps, lone images and missing transforms in a recording",
        epilog=_EPILOG,
    )
    parser.add_argument("bag", type=Path, metavar="BAG", help="folder of the recording")
    parser.add_argument("--json", action="store_true", help="print a list of objects")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    bag = Bag(options.bag)
    with progress(bag, "reading") as on_bytes:
        checks = inspect(bag, on_bytes)
    if options.json:
        print(json.dumps(as_objects(checks), indent=2))
    else:
        console = Console(width=None if sys.stdout.isatty() else _WIDTH)
        console.print(integrity_table(checks))
        for line in problems(checks):
            console.print(line, soft_wrap=True, highlight=False)
        count = sum(check.verdict == "ok" for check in checks)
        console.print(f"{count} of {len(checks)} checks are ok", highlight=False)
    return int(worst(checks) == "wrong")

"""ml2-receiver inspect: checks the quality of a recording."""

import argparse
import sys
from pathlib import Path

from rich.console import Console

from ml2_receiver.commands.options import Subparsers
from ml2_receiver.json_text import json_text

from ..bags.bag_reader import Bag, BagReader
from ..inspection.inspection import as_objects, inspect, worst
from ..inspection.table import integrity_table, problems
from .reading import add_headset, progress, say_apart, say_left_out

_WIDTH = 160
_EPILOG = """\
Reads any rosbag2 folder with an MCAP file, without ROS. Checks of each topic:
  broken messages, rate, missing messages, jitter and order of stamps
  latency: the time of recording minus the stamp
  for cameras: camera_info, metadata and transforms at the stamps of images
"wrong" is a fault for every use of the recording, "hint" only for some uses.

Exit code: 0, 1 if a check is "wrong", or 2 if the recording cannot be read.

examples:
  ml2-receiver inspect walk
  ml2-receiver inspect walk --json | jq '.[] | select(.verdict != "ok")'
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "inspect",
        help="find gaps, wrong stamps and missing parts in a recording",
        epilog=_EPILOG,
    )
    parser.add_argument("bag", type=Path, metavar="BAG", help="folder of the recording")
    add_headset(parser)
    parser.add_argument("--json", action="store_true", help="print a list of objects")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    is_one_chosen = options.headset is not None
    bag: Bag = BagReader(options.bag, options.headset) if is_one_chosen else Bag(options.bag)
    say_apart(bag.apart)
    with progress(bag, "reading") as on_bytes:
        checks = inspect(bag, on_bytes)
    say_left_out(bag.left_out)
    if options.json:
        print(json_text(as_objects(checks), indent=2))
    else:
        console = Console(width=None if sys.stdout.isatty() else _WIDTH)
        console.print(integrity_table(checks))
        for line in problems(checks):
            console.print(line, soft_wrap=True, highlight=False)
        count = sum(check.verdict == "ok" for check in checks)
        console.print(f"{count} of {len(checks)} checks are ok", highlight=False)
    return int(worst(checks) == "wrong")

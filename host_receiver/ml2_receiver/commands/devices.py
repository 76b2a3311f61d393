"""ml2-receiver devices: the headset, and what keeps its streams from running."""

import argparse
import dataclasses
import json

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ..configuration.table import load_table
from ..watch.devices import Device, read_device
from .config import Subparsers
from .live import PATIENCE_S, diagnostics_node
from .options import add_name

_EPILOG = """\
A headset connects to a receiver, so this asks the one that runs in this ROS domain. Exit code: 0,
or 2 without a receiver to ask.

examples:
  ml2-receiver devices
  ml2-receiver devices --json | jq '.streams[] | select(.state == "unavailable")'
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "devices",
        help="show the headset, its permissions, and why a stream is unavailable",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "--json", action="store_true", help="print one object, or null without headset"
    )
    add_name(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    with diagnostics_node() as node:
        session = node.rows(options.name, PATIENCE_S).get("session", {})
    device = read_device(session, load_table())
    if options.json:
        print(json.dumps(None if device is None else dataclasses.asdict(device), indent=2))
    elif device is None:
        print("no headset yet: start the app, or a simulated headset")
    else:
        Console().print(_headset(device))
    return 0


def _headset(device: Device) -> Table:
    title = f"{device.name}, {device.state}, running {device.software}, id {device.device_id}"
    table = Table("stream", "state", "why", title=escape(title), title_justify="left", box=None)
    for it in device.streams:
        table.add_row(it.stream, it.state, escape(it.reason))
    for name, is_granted in device.permissions.items():
        table.add_row(escape(name), "granted" if is_granted else "not granted", "")
    return table

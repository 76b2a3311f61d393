"""ml2-receiver devices: the headset, and what keeps its streams from running as configured."""

import argparse
import dataclasses
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from ml2_receiver.commands.options import Subparsers, add_receiver
from ml2_receiver.commands.session_port import add_keys
from ml2_receiver.json_text import json_text
from ml2_receiver.printable import markup
from ml2_receiver.security.paired_devices import PairedDevice, PairedDevices
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.adaptation import LOWERED

from ..doctor.devices import Device, read_device
from .live import PATIENCE_S, found_receiver

_EPILOG = """\
A headset connects to a receiver, so this asks the one that runs in this ROS domain; --paired reads
the folder of keys instead. Exit code: 0, or 2 without a receiver to ask.

examples:
  ml2-receiver devices
  ml2-receiver devices --paired      who may connect
  ml2-receiver devices --json | jq '.streams[] | select(.state == "unavailable")'
  ml2-receiver devices --json | jq '.streams[] | select(.lowered != "")'    for the link
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "devices",
        help="show the headset, and why a stream does not run",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "--json", action="store_true", help="print one object, or null without headset"
    )
    parser.add_argument(
        "--paired", action="store_true", help="list the devices that may connect, with --json too"
    )
    add_keys(parser)
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.paired:
        _show_paired(PairedDevices(options.keys).load(), is_json=options.json)
        return 0
    with found_receiver(options.name, PATIENCE_S) as node:
        device = read_device(node.rows(options.name, PATIENCE_S), load_table())
    if options.json:
        print(json_text(None if device is None else dataclasses.asdict(device), indent=2))
    elif device is None:
        print("no headset yet: start the app, or a simulated headset")
    else:
        Console().print(_headset(device))
    return 0


def _show_paired(devices: Sequence[PairedDevice], *, is_json: bool) -> None:
    if is_json:
        keys = ("name", "device_id", "paired", "fingerprint")
        print(json_text([{key: getattr(it, key) for key in keys} for it in devices], indent=2))
    elif not devices:
        print("no device is paired: run `ml2-receiver pair`")
    else:
        table = Table("name", "paired", "id", box=None)
        table.add_column("fingerprint", overflow="fold")
        for it in devices:
            name, paired, device_id = map(markup, (it.name, it.paired, it.device_id))
            table.add_row(name, paired, device_id, it.fingerprint)
        Console().print(table)


def _headset(device: Device) -> Table:
    title = f"{device.name}, {device.state}, running {device.software}, id {device.device_id}"
    table = Table("stream", "state", "why", title=markup(title), title_justify="left", box=None)
    for it in device.streams:
        lowered = f"{LOWERED}: {it.lowered}" if it.lowered else ""
        why = "; ".join(filter(None, (it.reason, lowered)))
        table.add_row(it.stream, markup(it.state), markup(why))
    for name, is_granted in device.permissions.items():
        table.add_row(markup(name), "granted" if is_granted else "not granted", "")
    return table

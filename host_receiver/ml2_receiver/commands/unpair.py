"""ml2-receiver unpair: a headset may not connect any more."""

import argparse

from ..security.paired_devices import PairedDevices
from .options import Subparsers
from .session_port import add_keys

_EPILOG = """\
A session of it ends at once. Exit code: 0, or 2 if no such device is paired.

examples:
  ml2-receiver devices --paired
  ml2-receiver unpair "Magic Leap 2"
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "unpair", help="do not let a headset connect any more", epilog=_EPILOG
    )
    parser.add_argument("device", metavar="NAME", help="its name, or its fingerprint")
    add_keys(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    device = PairedDevices(options.keys).remove(options.device)
    print(f"unpaired {device.name!r}, fingerprint {device.fingerprint}")
    return 0

"""ml2-receiver run: publishes what a headset sends."""

import argparse
import os
import signal
import socket
import sys
import threading
from importlib import resources
from pathlib import Path

from ..calibrated_sink import CalibratedSink
from ..config import load_config
from ..errors import RosError
from ..fastdds import apply_default_profile
from ..generated.version import VERSION
from ..server import Server, listen
from ..table import load_table
from .config import Subparsers

_DEFAULT_ADDRESS = ("127.0.0.1", 7755)


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "run",
        help="receive a headset and publish its topics",
        epilog="Whatever follows --ros-args goes to ROS 2.",
    )
    parser.add_argument("--config", type=Path, metavar="FILE", help="default: the packaged one")
    parser.add_argument(
        "--listen",
        type=_address,
        default=_DEFAULT_ADDRESS,
        metavar="HOST:PORT",
        help="default: 127.0.0.1:7755; port 0 lets the system choose",
    )
    parser.add_argument(
        "--start-paused",
        action="store_true",
        help="headsets send nothing until service ~/start is called",
    )
    parser.add_argument("--insecure", action="store_true", help="without effect so far")
    parser.add_argument("--insecure-eye-images", action="store_true", help="without effect so far")
    parser.add_argument("--ros-args", nargs=argparse.REMAINDER, default=[], help=argparse.SUPPRESS)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    with resources.as_file(resources.files("ml2_receiver") / "data/config.yaml") as packaged:
        config = load_config(options.config or packaged)
    table = load_table()
    listener = listen(options.listen)
    warning = apply_default_profile(os.environ)
    if warning is not None:
        print(f"WARNING: {warning}", file=sys.stderr)
    try:
        from ..ros import RosNode  # reads the profile
    except ModuleNotFoundError as error:
        raise RosError(f"{error.name} is missing: source ROS 2 Jazzy") from error
    node = RosNode(table, config.prefix, ["--ros-args", *options.ros_args])
    server = Server(
        listener,
        table,
        config.requests,
        CalibratedSink(node, config.calibrations),
        name=socket.gethostname(),
        software=f"ml2-receiver {VERSION}",
        is_paused=options.start_paused,
    )
    node.serve(server.report, server.begin)
    print(f"listening on {server.address}", flush=True)
    stopping.wait()
    server.stop()
    node.close()
    return 0


def _address(text: str) -> tuple[str, int]:
    host, colon, port = text.rpartition(":")
    if not colon or not host or not port.isdecimal() or int(port) > 0xFFFF:
        raise argparse.ArgumentTypeError(f"expected HOST:PORT, found {text!r}")
    return host.removeprefix("[").removesuffix("]"), int(port)

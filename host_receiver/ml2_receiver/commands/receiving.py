"""What the commands that act as the receiver share."""

import argparse
import os
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from ..config import Config, load_config
from ..errors import RosError
from ..fastdds import apply_default_profile
from ..generated.version import VERSION
from ..server import Server
from ..sink import Sink
from ..table import load_table

if TYPE_CHECKING:
    from ..ros import RosNode

DEFAULT_ADDRESS = ("127.0.0.1", 7755)


def add_options(parser: argparse.ArgumentParser) -> None:
    """--config, --listen and what goes to ROS."""
    parser.add_argument("--config", type=Path, metavar="FILE", help="default: the packaged one")
    parser.add_argument(
        "--listen",
        type=address,
        default=DEFAULT_ADDRESS,
        metavar="HOST:PORT",
        help="default: 127.0.0.1:7755; port 0 lets the system choose",
    )
    parser.add_argument("--insecure", action="store_true", help="without effect so far")
    parser.add_argument("--insecure-eye-images", action="store_true", help="without effect so far")
    parser.add_argument("--ros-args", nargs=argparse.REMAINDER, default=[], help=argparse.SUPPRESS)


def address(text: str) -> tuple[str, int]:
    """HOST:PORT, for argparse."""
    host, colon, port = text.rpartition(":")
    if not colon or not host or not port.isdecimal() or int(port) > 0xFFFF:
        raise argparse.ArgumentTypeError(f"expected HOST:PORT, found {text!r}")
    return host.removeprefix("[").removesuffix("]"), int(port)


def stop_signal() -> threading.Event:
    """Set by Ctrl-C and by SIGTERM."""
    stopping = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopping.set())
    return stopping


def read_config(options: argparse.Namespace) -> Config:
    """The file of --config, or the packaged one."""
    with resources.as_file(resources.files("ml2_receiver") / "data/config.yaml") as packaged:
        return load_config(options.config or packaged)


def make_node(config: Config, ros_arguments: list[str]) -> "RosNode":
    """The ROS node, with enough shared memory for images."""
    warning = apply_default_profile(os.environ)
    if warning is not None:
        print(f"WARNING: {warning}", file=sys.stderr)
    try:
        from ..ros import RosNode  # reads the profile
    except ModuleNotFoundError as error:
        raise RosError(f"{error.name} is missing: source ROS 2 Jazzy") from error
    return RosNode(load_table(), config.prefix, ["--ros-args", *ros_arguments])


@contextmanager
def serving(
    listener: socket.socket, config: Config, sink: Sink, *, is_paused: bool = False
) -> Iterator[Server]:
    """A server that listens until left."""
    server = Server(
        listener,
        load_table(),
        config.requests,
        sink,
        name=socket.gethostname(),
        software=f"ml2-receiver {VERSION}",
        is_paused=is_paused,
    )
    try:
        yield server
    finally:
        server.stop()

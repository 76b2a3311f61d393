"""What the commands that act as the receiver share."""

import argparse
import socket
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from ..configuration.config import Config
from ..configuration.config_file import ConfigFile
from ..configuration.table import load_table
from ..generated.version import VERSION
from ..link.discovery import Announcement
from ..link.server import Server
from ..topics.sink import Sink
from .config import add_file
from .options import name
from .ros_start import node_arguments, ros_needed, use_profile

if TYPE_CHECKING:
    from ..ros import RosNode

DEFAULT_ADDRESS = ("127.0.0.1", 7755)


def add_options(parser: argparse.ArgumentParser) -> None:
    """--config, --listen and what goes to ROS."""
    add_file(
        parser,
        "--config",
        metavar="FILE",
        help="default: ~/.config/ml2_receiver/config.yaml, or where there is none the packaged one",
    )
    parser.add_argument(
        "--listen",
        type=address,
        default=DEFAULT_ADDRESS,
        metavar="HOST:PORT",
        help="default: 127.0.0.1:7755; port 0 lets the system choose",
    )
    parser.add_argument(
        "--name",
        type=name,
        default="",
        help="tells several headsets apart: node and topics are under /NAME, frame ids begin with"
        " NAME/, and headsets find this receiver as NAME; default: none, found as this machine's",
    )
    parser.add_argument(
        "--start-paused",
        action="store_true",
        help="headsets send nothing until service ~/start is called",
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


def config_file(options: argparse.Namespace) -> ConfigFile:
    """That of --config, or the user's own."""
    return ConfigFile(options.config) if options.config else ConfigFile.of_user()


def load(file: ConfigFile, options: argparse.Namespace) -> Config:
    """What it says, for the headset of --name."""
    return replace(file.load(), name=options.name)


def make_node(config: Config, options: argparse.Namespace) -> "RosNode":
    """The ROS node, with enough shared memory for images."""
    use_profile()
    with ros_needed():
        from ..ros import RosNode  # reads the profile
    return RosNode(load_table(), config, node_arguments(options.ros_args, config.name))


def announce(listener: socket.socket, config: Config) -> Announcement:
    """Lets headsets find it by name; takes its time, and may go on while ROS starts."""
    return Announcement(_name(config), listener.getsockname(), _warn_unannounced)


@contextmanager
def serving(
    listener: socket.socket,
    announcement: Announcement,
    config: Config,
    sink: Sink,
    *,
    is_paused: bool = False,
    idle: Callable[[], Collection[str]] = tuple,
) -> Iterator[Server]:
    """A server that listens until left, when the announcement ends first; the last arguments are
    the Server's."""
    server = Server(
        listener,
        load_table(),
        config.requests,
        sink,
        name=_name(config),
        software=f"ml2-receiver {VERSION}",
        frame_prefix=config.frame_prefix,
        is_paused=is_paused,
        idle=idle,
    )
    try:
        yield server
    finally:
        announcement.close()
        server.stop()


def _name(config: Config) -> str:
    return config.name or socket.gethostname()


def _warn_unannounced(reason: str) -> None:
    message = (
        f"WARNING: headsets do not find this receiver by name, give them its address: {reason}"
    )
    print(message, file=sys.stderr)

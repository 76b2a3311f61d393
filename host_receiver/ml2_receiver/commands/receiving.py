"""Common parts of the commands that act as the receiver."""

import argparse
import gc
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from ..configuration.app_rules import AppRules, matches
from ..configuration.config import Config
from ..configuration.config_file import ConfigFile
from ..configuration.mounts import load_mounts
from ..configuration.parameter_file import MAX_BYTES, node_names
from ..configuration.whole_file import read_file
from ..errors import ConfigError, Problem
from ..generated.version import VERSION
from ..session.graph import Graph
from ..session.server import Server
from ..session.settings import ReceiverSettings
from ..session.sink import Sink
from ..topics.calibrated_sink import CalibratedSink
from ..topics.fan_out import FanOut
from ..topics.mounted_sink import MountedSink
from .options import add_file, add_ros_args, name
from .ros_start import node_arguments, node_name, ros_needed
from .session_port import SessionPort, add_insecure, add_keys

if TYPE_CHECKING:
    from ..ros.graph import RosGraph
    from ..ros.node import RosNode

# The thread of the inertial samples asks for the interpreter several times for each of them. Other
# threads, such as that of /diagnostics, would keep it for 5 ms each time.
_SWITCH_S = 0.0005


def add_options(parser: argparse.ArgumentParser) -> None:
    """--config, --listen, --keys and what goes to ROS."""
    add_file(
        parser,
        "--config",
        metavar="FILE",
        help="default: ~/.config/ml2-sensors/config.yaml, or where there is none the packaged one",
    )
    parser.add_argument(
        "--listen",
        type=address,
        metavar="HOST:PORT",
        help="port 0 lets the system choose; default: port 7755, of this machine only, and of all"
        " interfaces once a device is paired",
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
    add_keys(parser)
    add_insecure(parser)
    add_ros_args(parser)


def address(text: str) -> tuple[str, int]:
    """HOST:PORT, for argparse."""
    host, colon, port = text.rpartition(":")
    if not colon or not host or not port.isdecimal():
        raise argparse.ArgumentTypeError(f"expected HOST:PORT, found {text!r}")
    if int(port) > 0xFFFF:
        message = f"expected a port from 0 to 65535, found {port} in {text!r}"
        raise argparse.ArgumentTypeError(message)
    return host.removeprefix("[").removesuffix("]"), int(port)


def config_file(options: argparse.Namespace) -> ConfigFile:
    """Returns the file of --config, or the user's own file."""
    node = _node_path(options)
    return ConfigFile(options.config, node=node) if options.config else ConfigFile.of_user(node)


def _node_path(options: argparse.Namespace) -> str:
    name = node_name(getattr(options, "ros_args", ()))
    return f"/{options.name}/{name}" if options.name else f"/{name}"


def load(file: ConfigFile, options: argparse.Namespace) -> Config:
    """Returns the configuration in the file, for the receiver named --name.

    Says on standard error what the file has for others.
    """
    config = file.load()
    print_ignored(config.ignored, str(file.path))
    return replace(config, name=options.name)


def print_ignored(ignored: Iterable[Problem], file: str) -> None:
    """Says on standard error what a file has that is not for the receiver."""
    for problem in ignored:
        print(problem.located_in(file), file=sys.stderr)


def ros_node(config: Config, options: argparse.Namespace) -> "RosNode | None":
    """The node, with enough shared memory for images; None with --no-ros."""
    if options.no_ros:
        return None
    for text in _without_effect(options.ros_args, _node_path(options)):
        print(f"WARNING: {text}", file=sys.stderr)
    with ros_needed(sends_images=True):
        from ..ros.node import RosNode  # reads the profile
    return RosNode(config, node_arguments(options.ros_args, config.name))


def _without_effect(ros_args: Sequence[str], node: str) -> Iterator[str]:
    """Says which files of ROS's parameters have none for the node; ROS says nothing of them."""
    for flag, file in pairwise(ros_args):
        if flag == "--params-file":
            with suppress(ConfigError, OSError):  # of which ROS tells
                names = node_names(read_file(Path(file), MAX_BYTES))
                if not any(matches(it, node) for it in names):
                    yield f"{file} has nothing for {node}: it is for {', '.join(names)}"


@contextmanager
def ros_sink(
    node: "RosNode", server: Server, file: ConfigFile, sink: CalibratedSink, sinks: FanOut
) -> Iterator[None]:
    """Publishes as the node, and answers its services, until left; adds itself to `sinks`."""
    from ..ros.sink import RosSink

    with RosSink(node, server, file, sink.use, sinks):
        yield


def ros_graph(node: "RosNode") -> "RosGraph":
    """Returns what opens topics for apps with the node, to be used as a context manager."""
    from ..ros.graph import RosGraph

    return RosGraph(node)


def new_server(
    port: SessionPort,
    config: Config,
    sink: Sink,
    graph: Graph | None = None,
    *,
    is_paused: bool = False,
) -> Server:
    """The server of a command, which running() runs; without a graph, apps open nothing.

    Raises:
        CalibrationError: the saved mounts of inertial units cannot be read.
    """
    server = Server(
        port.listener,
        port.access,
        MountedSink(sink, load_mounts(), config.frame_prefix),
        config.requests,
        ReceiverSettings(
            port.name,
            f"ml2-receiver {VERSION}",
            config.frame_prefix,
            port.excluded,
            app=lambda: port.allowed(graph.rules) if graph else AppRules(),
            graph=graph,
        ),
        link=config.link,
        is_lazy=config.is_lazy,
        is_paused=is_paused,
        access_changed=lambda: port.listen_again(server),
    )
    return server


@contextmanager
def running(server: Server, port: SessionPort) -> Iterator[None]:
    """Headsets can connect until left."""
    sys.setswitchinterval(_SWITCH_S)
    # Else each collection of the oldest generation holds back samples for 20 to 60 ms.
    gc.collect()
    gc.freeze()
    server.start()
    try:
        yield
    finally:
        port.close()
        server.stop()
        gc.unfreeze()

"""ml2-receiver run: publishes what a headset sends."""

import argparse
from contextlib import ExitStack

from ..configuration.forecast import images_mbit_per_s
from ..configuration.link_fit import bound_mbit_per_s, link_in_words
from ..topics.calibrated_sink import CalibratedSink
from ..topics.fan_out import FanOut
from .options import Subparsers
from .printed_events import PrintedEvents
from .receiving import (
    add_options,
    config_file,
    load,
    new_server,
    ros_graph,
    ros_node,
    ros_sink,
    running,
)
from .ros_start import node_name, topic_remappings
from .session_port import SessionPort
from .stopping import stop_signal
from .view_beside import view_beside
from .zenoh_start import add_zenoh, check, check_middleware, zenoh_output

_EPILOG = """\
Headsets find it by its name where it listens on the network. Whatever follows --ros-args goes to
ROS 2.

examples:
  ml2-receiver run                                     for a simulated headset on this machine
  ml2-receiver run --listen 0.0.0.0:7755 --config my.yaml
  ml2-receiver run --listen 0.0.0.0:7756 --name robot1    a second headset, kept apart
  ml2-receiver run --view                              and show its streams in a browser
  ml2-receiver run --no-ros --zenoh tcp/HOST:7447      on Zenoh, from a PC without ROS 2
  ml2-receiver run --ros-args --log-level debug
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "run",
        help="receive a headset and publish its topics",
        epilog=_EPILOG,
    )
    add_options(parser)
    parser.add_argument(
        "--view", action="store_true", help="also run `ml2-receiver view`, the page in a browser"
    )
    add_zenoh(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    check(options)
    stopping = stop_signal()
    file = config_file(options)
    config = load(file, options)
    with ExitStack() as stack:
        port = stack.enter_context(SessionPort(options))
        node = ros_node(config, options)
        if node is not None:
            stack.enter_context(node)
            config = node.config
            check_middleware(node.middleware, options.zenoh)
        sinks = FanOut([PrintedEvents()] if node is None else [])
        sink = CalibratedSink(sinks, config.calibrations)
        graph = None if node is None else stack.enter_context(ros_graph(node))
        server = new_server(port, config, sink, graph, is_paused=options.start_paused)
        if node is not None:
            stack.enter_context(ros_sink(node, server, file, sink, sinks))
        name = node_name(options.ros_args) if node is None else node.name
        remapped = str if node is None else node.remapped
        if (zenoh := zenoh_output(options, config, sinks, server, name, remapped)) is not None:
            stack.enter_context(zenoh)
        stack.enter_context(running(server, port))
        print(f"listening on {server.address}", flush=True)
        print(f"configuration: {'as packaged' if file.is_packaged else file.path}", flush=True)
        needs = images_mbit_per_s(config)
        asked = {id: it for id, it in needs.items() if id not in port.excluded}
        print(link_in_words(config, asked, bound_mbit_per_s(config)), flush=True)
        if options.view:
            remappings = topic_remappings(options.ros_args)
            number = port.listener.getsockname()[1]
            stack.enter_context(view_beside(options.name, options.keys, number, remappings))
        stopping.wait()
    return 0

"""ml2-receiver run: publishes what a headset sends."""

import argparse

from ..server import listen
from .config import Subparsers
from .receiving import add_options, make_node, read_config, serving, stop_signal


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "run",
        help="receive a headset and publish its topics",
        epilog="Whatever follows --ros-args goes to ROS 2.",
    )
    parser.add_argument(
        "--start-paused",
        action="store_true",
        help="headsets send nothing until service ~/start is called",
    )
    add_options(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    config = read_config(options)
    listener = listen(options.listen)
    node = make_node(config, options.ros_args)
    with serving(listener, config, node, is_paused=options.start_paused) as server:
        node.serve(server.report, server.begin)
        print(f"listening on {server.address}", flush=True)
        stopping.wait()
    node.close()
    return 0

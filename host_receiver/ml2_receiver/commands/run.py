"""ml2-receiver run: publishes what a headset sends."""

import argparse
from contextlib import ExitStack

from ..configuration.forecast import images_mbit_per_s
from ..configuration.link_fit import bound_mbit_per_s, link_in_words
from ..topics.calibrated_sink import CalibratedSink
from ..topics.fan_out import FanOut
from .config import Subparsers
from .endpoint import Endpoint
from .receiving import add_options, config_file, load, make_node, serving
from .stopping import stop_signal
from .view_beside import view_beside

_EPILOG = """\
Headsets find it by its name where it listens on the network. Whatever follows --ros-args goes to
ROS 2.

examples:
  ml2-receiver run                                     for a simulated headset on this machine
  ml2-receiver run --listen 0.0.0.0:7755 --config my.yaml
  ml2-receiver run --listen 0.0.0.0:7756 --name robot1    a second headset, kept apart
  ml2-receiver run --view                              and show its streams in a browser
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
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    file = config_file(options)
    config = load(file, options)
    with ExitStack() as stack:
        endpoint = stack.enter_context(Endpoint(options))
        node = make_node(config, options)
        stack.callback(node.close)
        sinks = FanOut([node])
        sink = CalibratedSink(sinks, node.config.calibrations)
        idle, is_paused = node.idle_streams, options.start_paused
        with serving(endpoint, node.config, sink, is_paused=is_paused, idle=idle) as server:
            node.serve(server, file, sink.use, sinks)
            print(f"listening on {server.address}", flush=True)
            print(f"configuration: {'as packaged' if file.is_packaged else file.path}", flush=True)
            needs = images_mbit_per_s(node.config)
            asked = {id: it for id, it in needs.items() if id not in endpoint.excluded}
            print(link_in_words(node.config, asked, bound_mbit_per_s(node.config)), flush=True)
            if options.view:
                stack.enter_context(view_beside(options.name))
            stopping.wait()
    return 0

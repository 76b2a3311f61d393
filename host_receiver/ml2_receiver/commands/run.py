"""ml2-receiver run: publishes what a headset sends."""

import argparse
from collections.abc import Callable, Collection
from contextlib import ExitStack
from typing import TYPE_CHECKING

from ..configuration.forecast import images_mbit_per_s
from ..configuration.link_fit import bound_mbit_per_s, link_in_words
from ..topics.calibrated_sink import CalibratedSink
from .options import Subparsers
from .receiving import add_options, config_file, load, ros_output, serving
from .ros_start import topic_remappings
from .session_port import SessionPort
from .stopping import stop_signal
from .view_beside import view_beside
from .zenoh_start import add_zenoh, check, check_middleware, zenoh_output

if TYPE_CHECKING:
    from ..ros.node import RosNode
    from ..zenoh.output import ZenohOutput

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
        session_port = stack.enter_context(SessionPort(options))
        config, node, sinks = stack.enter_context(ros_output(config, options))
        if node is not None:
            check_middleware(node.middleware, options.zenoh)

        def is_lazy() -> bool:
            return bool((config if node is None else node.config).values["publish.lazy"])

        remapped = str if node is None else node.remapped
        zenoh = zenoh_output(options, config, sinks, is_lazy, remapped)
        sink = CalibratedSink(sinks, config.calibrations)
        idle, is_paused = _idle(node, zenoh, is_lazy), options.start_paused
        with serving(session_port, config, sink, is_paused=is_paused, idle=idle) as server:
            if node is not None:
                node.serve(server, file, sink.use, sinks)
            if zenoh is not None:
                stack.callback(zenoh.close)
                zenoh.serve(server)
            print(f"listening on {server.address}", flush=True)
            print(f"configuration: {'as packaged' if file.is_packaged else file.path}", flush=True)
            needs = images_mbit_per_s(config)
            asked = {id: it for id, it in needs.items() if id not in session_port.excluded}
            print(link_in_words(config, asked, bound_mbit_per_s(config)), flush=True)
            if options.view:
                remappings = topic_remappings(options.ros_args)
                port = session_port.listener.getsockname()[1]
                stack.enter_context(view_beside(options.name, options.keys, port, remappings))
            stopping.wait()
    return 0


def _idle(
    node: "RosNode | None", zenoh: "ZenohOutput | None", is_lazy: Callable[[], bool]
) -> Callable[[], Collection[str]]:
    """Returns a function that returns the streams that nobody needs at present."""

    def idle() -> Collection[str]:
        demand = {} if zenoh is None else zenoh.demand()
        if node is not None:
            return node.idle_streams() - {stream for stream, wanted in demand.items() if wanted}
        return {stream for stream, wanted in demand.items() if not wanted} if is_lazy() else ()

    return idle

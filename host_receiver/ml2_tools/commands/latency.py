"""ml2-receiver latency: shows the latency from capture to subscriber by stage."""

from __future__ import annotations

import argparse
import importlib.util
import math
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.live import Live

from ml2_receiver.commands.options import Subparsers, add_receiver
from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.errors import NO_RECEIVER_HINT

from ..errors import LatencyError
from ..monitoring.latency_table import latency_table, write_plot
from .live import PATIENCE_S, looking, named

if TYPE_CHECKING:
    from ..monitoring.latency_node import LatencyNode

_POLL_S = 0.1
_REDRAW_S = 0.5
_WIDTH = 150
# The error message and its hint by the state of the session.
_MISSING = {
    None: ("no receiver in this ROS domain", NO_RECEIVER_HINT),
    "waiting": (
        "the receiver has no headset",
        "Start the app on the headset, or a simulated headset.",
    ),
    "connected": (
        "a headset is connected, but no messages arrive",
        "`ml2-receiver devices` lists the streams: all may be refused or paused.",
    ),
}


_EPILOG = """\
examples:
  ml2-receiver latency                live, until Ctrl-C
  ml2-receiver latency --once --duration 5 --plot latency.png
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "latency",
        help="show the latency of messages by stage while `run` runs",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "--duration",
        type=_seconds,
        default=10.0,
        metavar="S",
        help="average over the last S seconds; default: 10",
    )
    parser.add_argument("--once", action="store_true", help="print the table once and end")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="draw the last values as a .png")
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.plot is not None and importlib.util.find_spec("matplotlib") is None:
        raise LatencyError("--plot needs matplotlib: pip install matplotlib")
    stopping = stop_signal()
    with ros_needed():
        from ..monitoring.latency_node import LatencyNode
    node = LatencyNode(options.name, windows=math.ceil(options.duration))
    try:
        with looking(f"messages of {named(options.name)}", f"for up to {PATIENCE_S:g} s"):
            _await_messages(node, stopping)
        if stopping.is_set():
            return 0
        _show(node, stopping, options)
        if options.plot is not None:
            write_plot(node.breakdowns(), options.plot)
    finally:
        node.close()
    return 0


def _await_messages(node: LatencyNode, stopping: threading.Event) -> None:
    """Waits for the first figures, or until `stopping` is set.

    Raises:
        LatencyError: there is no receiver, no headset, or no messages.
    """
    deadline_s = time.monotonic() + PATIENCE_S
    while all(breakdown is None for _, breakdown in node.breakdowns().values()):
        if stopping.wait(_POLL_S):
            return
        if time.monotonic() > deadline_s:
            state = node.session_state
            otherwise = (f"the session is {state}", "Start the app on the headset again.")
            message, hint = _MISSING.get(state, otherwise)
            raise LatencyError(message, hint=hint)


def _show(node: LatencyNode, stopping: threading.Event, options: argparse.Namespace) -> None:
    console = Console(width=None if sys.stdout.isatty() else _WIDTH)
    if options.once:
        stopping.wait(options.duration)
        console.print(latency_table(node.breakdowns(), options.duration))
        return
    print("measuring until Ctrl-C", flush=True)
    with Live(console=console, refresh_per_second=1 / _REDRAW_S) as live:
        live.update(latency_table(node.breakdowns(), options.duration))
        while not stopping.wait(_REDRAW_S):
            live.update(latency_table(node.breakdowns(), options.duration))


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 1 <= seconds <= 3600:
        raise argparse.ArgumentTypeError(f"expected 1 to 3600 seconds, found {text!r}")
    return seconds

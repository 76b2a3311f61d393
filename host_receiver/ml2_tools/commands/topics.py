"""ml2-receiver topics: shows the state of each topic."""

import argparse
import sys

from rich.console import Console
from rich.live import Live

from ml2_receiver.commands.options import Subparsers, add_receiver
from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.json_text import json_text

from ..monitoring.topic_table import topic_figures, topic_table
from .live import PATIENCE_S, found_receiver

_REDRAW_S = 0.5
_WIDTH = 150
_EPILOG = """\
"lost" counts the messages that were produced and not published. Topics without an expected rate
come as delivered. A topic that delivers nothing has the state and reason that `devices` shows.
Exit code: 0, or 2 without a receiver.

examples:
  ml2-receiver topics                live, until Ctrl-C
  ml2-receiver topics --once
  ml2-receiver topics --json | jq '.[] | {topic, rate_hz, lost}'
  ml2-receiver topics --json | jq '.[] | select(.stream_state != "running")'
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "topics",
        help="show rates, losses and latencies of every topic",
        epilog=_EPILOG,
    )
    parser.add_argument("--once", action="store_true", help="print the table once and end")
    parser.add_argument("--json", action="store_true", help="print a list of objects once and end")
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    console = Console(width=None if sys.stdout.isatty() else _WIDTH)
    with found_receiver(options.name, PATIENCE_S) as node:
        rows = node.rows(options.name, PATIENCE_S)
        if options.json:
            print(json_text(topic_figures(rows), indent=2))
        elif options.once:
            console.print(topic_table(rows, console))
        else:
            stopping = stop_signal()
            print("watching until Ctrl-C", flush=True)
            with Live(topic_table(rows, console), console=console, auto_refresh=False) as live:
                while not stopping.wait(_REDRAW_S):
                    rows = node.rows(options.name, PATIENCE_S)
                    live.update(topic_table(rows, console), refresh=True)
    return 0

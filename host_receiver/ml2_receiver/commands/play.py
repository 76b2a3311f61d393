"""ml2-receiver play: sends a recording to a receiver, as the headset did."""

import argparse
import math
import sys
import threading
from contextlib import ExitStack
from pathlib import Path

from rich.live import Live

from ..configuration.table import load_table
from ..errors import PlaybackError
from ..playback.lane import Destination
from ..playback.player import Player
from ..playback.session import Session
from ..recording.bag_reader import BagReader
from ..security.identity import Identity
from .config import Subparsers
from .entrance import PORT, add_keys
from .receiving import address
from .stopping import stop_signal

_REDRAWS_PER_SECOND = 2.0
_POLL_S = 0.1
# A receiver that ends says why on another lane than the one that breaks first.
_GOODBYE_S = 1.0
_EXAMPLES = """examples:
  ml2-receiver play walk                                to a receiver on this computer
  ml2-receiver play walk --receiver 192.168.1.5:7755    to another one
  ml2-receiver play walk --rate 0.5 --loop              half as fast, until Ctrl-C

The receiver has to have the same keys, as all of this user on this computer have. To one that has
others, both with --insecure.

Messages are sent as they were recorded, so their stamps are those of the recording. Only what
the receiver's configuration asks for is sent; streams that were not recorded are refused."""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "play",
        help="send a recording to a receiver as a headset would",
        epilog=_EXAMPLES,
    )
    parser.add_argument("bag", type=Path, metavar="BAG", help="folder that `record` made")
    parser.add_argument(
        "--receiver",
        type=address,
        default=("127.0.0.1", PORT),
        metavar="HOST:PORT",
        help="default: 127.0.0.1:7755",
    )
    parser.add_argument(
        "--rate", type=_rate, default=1.0, metavar="R", help="2 is twice as fast; default: 1"
    )
    parser.add_argument("--loop", action="store_true", help="begin again at the end")
    add_keys(parser)
    parser.add_argument(
        "--insecure", action="store_true", help="to a receiver that was started with --insecure"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    reader = BagReader(options.bag)
    identity = None if options.insecure else Identity.of(options.keys)
    session = Session(Destination(options.receiver, identity), reader, load_table(), stopping)
    player = Player(reader, load_table(), session, options.rate)
    try:
        _play(player, session, stopping, is_looping=options.loop)
    except PlaybackError as error:
        stopping.wait(_GOODBYE_S)
        raise PlaybackError(session.reason or str(error)) from error
    finally:
        session.finish()
    print(f"played {_line(player)}")
    if session.reason is not None:
        raise PlaybackError(session.reason)
    return 0


def _play(player: Player, session: Session, stopping: threading.Event, *, is_looping: bool) -> None:
    while not session.started.wait(_POLL_S):
        if stopping.is_set():
            return
    print("playing until Ctrl-C" if is_looping else "playing", flush=True)
    with ExitStack() as stack:
        if sys.stdout.isatty():
            stack.enter_context(
                Live(
                    get_renderable=lambda: _line(player),
                    refresh_per_second=_REDRAWS_PER_SECOND,
                    transient=True,
                )
            )
        player.play(stopping)
        while is_looping and not stopping.is_set():
            session.epoch += 1
            player.play(stopping)


def _line(player: Player) -> str:
    return f"{player.sent} messages, {player.sent_bytes / 1e6:.1f} MB"


def _rate(text: str) -> float:
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not 0 < rate < math.inf:
        raise argparse.ArgumentTypeError(f"expected a rate above 0, found {text!r}")
    return rate

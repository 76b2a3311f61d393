"""ml2-receiver play: sends a recording to a receiver as the headset did."""

import argparse
import math
import sys
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, nullcontext
from functools import partial
from pathlib import Path

from rich.live import Live

from ml2_receiver.commands.options import TOPICS, Subparsers, above_zero, complete
from ml2_receiver.commands.receiving import address
from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.commands.session_port import PORT, add_keys
from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.printable import printable
from ml2_receiver.security.identity import Identity
from ml2_receiver.table.reader import load_table

from ..bags.bag_reader import BagReader
from ..errors import PlaybackError
from ..playback.answers import Repertoire
from ..playback.lane import Destination
from ..playback.player import Player
from ..playback.session import PlaybackSession
from ..playback.timeline import Timeline
from .keys import LEFT, RIGHT, Keys
from .reading import add_headset, say_apart, say_left_out

_REDRAWS_PER_SECOND = 2.0
_POLL_S = 0.1
_JUMP_S = 5.0
_MOST_S, _MOST_RATE = 2e10, 1e6  # recordings have times of 64 bits
# After a lane breaks, the receiver's reason may arrive on the control lane within this time.
_GOODBYE_S = 1.0
_EXAMPLES = """examples:
  ml2-receiver play walk                                to a receiver on this computer
  ml2-receiver play walk --receiver 192.168.1.5:7755    to another one
  ml2-receiver play walk --rate 0.5 --loop              half as fast, until Ctrl-C
  ml2-receiver play walk --start-offset 60 --start-paused
  ml2-receiver play walk --topics /tf world_left/image_raw world_left/camera_info
  ml2-receiver play walk --clock                        for nodes with use_sim_time
  ml2-receiver play walk --headset robot2               one of several headsets

keys, on a terminal: space pauses and resumes, the arrows left and right jump 5 s back and forward.

The receiver must use the same --keys folder, as all commands of one user do by default. Otherwise
start both with --insecure.

Messages are sent unchanged, so their stamps are those of the recording. Only streams that the
receiver's configuration enables are sent, and a camera only with the format of the recording.
Exit code: 0; 1 if a stream or a topic was refused or nothing was sent, with the reason on stderr;
2 if the recording could not be played."""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "play",
        help="send a recording to a receiver as a headset would",
        epilog=_EXAMPLES,
    )
    parser.add_argument("bag", type=Path, metavar="BAG", help="folder that `record` made")
    add_headset(parser)
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
    topics = parser.add_argument(
        "--topics",
        nargs="+",
        default=[],
        metavar="TOPIC",
        help="send only these; names as in the recording, with or without the prefix",
    )
    complete(topics, TOPICS)
    parser.add_argument(
        "--start-offset",
        type=_offset,
        default=0.0,
        metavar="S",
        help="begin S seconds after the first message",
    )
    parser.add_argument("--start-paused", action="store_true", help="wait for the space bar")
    parser.add_argument(
        "--clock",
        action="store_true",
        help="publish the time of the recording on /clock; needs ROS 2",
    )
    add_keys(parser)
    parser.add_argument(
        "--insecure", action="store_true", help="play to a receiver that runs with --insecure"
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.start_paused and not sys.stdin.isatty():
        raise PlaybackError("--start-paused needs a terminal, because the space bar ends the pause")
    stopping = stop_signal()
    reader, table = BagReader(options.bag, options.headset), load_table()
    say_apart(reader.apart)
    repertoire = Repertoire.of(reader, table, options.topics)
    timeline = _timeline(reader, options)
    identity = None if options.insecure else Identity.of(options.keys)
    with _clock(timeline) if options.clock else nullcontext():
        session = PlaybackSession(
            Destination(options.receiver, identity),
            reader.config.headset,
            repertoire,
            _log_line,
            stopping,
        )
        player = Player(reader, repertoire, session, timeline)
        try:
            _play(player, session, timeline, stopping, is_looping=options.loop)
        except PlaybackError as error:
            stopping.wait(_GOODBYE_S)
            raise PlaybackError(session.reason or str(error)) from error
        finally:
            session.finish()
    print(f"played {_progress(player, timeline)}")
    say_left_out(reader.left_out)
    if player.unsent:
        counts = ", ".join(f"{count} of {topic}" for topic, count in sorted(player.unsent.items()))
        _log_line(f"not sent: {counts}")
    if session.reason is not None:
        raise PlaybackError(session.reason)
    for name in repertoire.surplus:
        _log_line(f"{name} was not played: it is above the limit of custom topics per headset")
    is_whole = player.sent and not session.refused and not repertoire.surplus
    return 0 if is_whole else 1


def _timeline(reader: BagReader, options: argparse.Namespace) -> Timeline:
    begin_ns = reader.begin_ns
    start_ns = begin_ns + round(options.start_offset * 1e9)
    return Timeline(begin_ns, start_ns, options.rate, is_paused=options.start_paused)


def _clock(timeline: Timeline) -> AbstractContextManager[object]:
    with ros_needed():
        from ..playback.ros_clock import RosClock
    return RosClock(timeline)


def _play(
    player: Player,
    session: PlaybackSession,
    timeline: Timeline,
    stopping: threading.Event,
    *,
    is_looping: bool,
) -> None:
    while not session.started.wait(_POLL_S):
        if stopping.is_set():
            return
    print("playing until Ctrl-C" if is_looping else "playing", flush=True)
    _, start_ns = timeline.position
    keys: dict[str, Callable[[], None]] = {
        " ": timeline.toggle,
        LEFT: partial(timeline.jump_by, -_JUMP_S),
        RIGHT: partial(timeline.jump_by, _JUMP_S),
    }
    with ExitStack() as stack:
        stack.enter_context(Keys(keys))
        if sys.stdout.isatty():
            stack.enter_context(
                Live(
                    get_renderable=lambda: _progress(player, timeline),
                    refresh_per_second=_REDRAWS_PER_SECOND,
                    transient=True,
                )
            )
        player.play(stopping)
        while is_looping and not stopping.is_set():
            session.epoch += 1
            timeline.jump(start_ns)
            player.play(stopping)


def _progress(player: Player, timeline: Timeline) -> str:
    paused = ", paused" if timeline.is_paused else ""
    sent = f"{player.sent} messages, {player.sent_bytes / 1e6:.1f} MB"
    return f"{sent}, to {timeline.offset_s:.1f} s{paused}"


def _log_line(text: str) -> None:
    print(printable(text), file=sys.stderr, flush=True)


def _offset(text: str) -> float:
    try:
        offset_s = float(text)
    except ValueError:
        offset_s = math.nan
    if not 0 <= offset_s < _MOST_S:
        raise argparse.ArgumentTypeError(f"expected seconds from 0 to {_MOST_S:g}, found {text!r}")
    return offset_s


def _rate(text: str) -> float:
    rate = above_zero(text)
    if rate > _MOST_RATE:
        raise argparse.ArgumentTypeError(f"expected a rate up to {_MOST_RATE:g}, found {text!r}")
    return rate

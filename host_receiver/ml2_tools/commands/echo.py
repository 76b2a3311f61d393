"""ml2-receiver echo: prints the messages of a topic."""

import argparse
import signal
import sys
from contextlib import ExitStack
from difflib import get_close_matches

from ml2_receiver.commands.options import TOPICS, Subparsers, add_receiver, complete
from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.printable import printable
from ml2_receiver.table.reader import load_table

from .live import PATIENCE_S, looking

_EPILOG = """\
Works like `ros2 topic echo` for any topic of the ROS domain. Of a long array it prints only the
first elements. For rates, as of `ros2 topic hz`, use `ml2-receiver topics`.

examples:
  ml2-receiver echo head_pose                    of a receiver with the packaged prefix
  ml2-receiver echo /tf --once
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "echo", help="print the messages of a topic as YAML", epilog=_EPILOG
    )
    topic = parser.add_argument(
        "topic", metavar="TOPIC", help="a name without / is under /magic_leap2"
    )
    complete(topic, TOPICS)
    parser.add_argument("--once", action="store_true", help="print one message and end")
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `| head` ends it silently
    prefix = load_table().sections["general"].keys["topic_name"].default
    prefix = f"{f'/{options.name}' if options.name else ''}{prefix}/"
    topic = options.topic if options.topic.startswith("/") else prefix + options.topic
    if topic.startswith(prefix):  # before ROS starts, which takes a second
        _say_nearest(topic.removeprefix(prefix))
    with ExitStack() as waiting:

        def found() -> None:
            waiting.close()
            waiting.enter_context(looking(f"messages of {printable(topic)}", "until Ctrl-C"))

        looked_for = looking(f"a publisher of {printable(topic)}", f"for up to {PATIENCE_S:g} s")
        waiting.enter_context(looked_for)
        with ros_needed():
            from ..monitoring.topic_reader import as_text, messages
        for message in messages(topic, PATIENCE_S, stopping, found):
            waiting.close()
            print(f"{as_text(message)}---", flush=True)
            if options.once:
                break
    return 0


def _say_nearest(name: str) -> None:
    """Says which topic is meant, if this belongs to no stream."""
    names = [it.name for stream in load_table().streams.values() for it in stream.topics]
    if name.partition("/")[0] not in {it.partition("/")[0] for it in names}:
        for close in get_close_matches(name, names, 1, cutoff=0.8):
            said = f"no sensor has the topic {printable(name)}; did you mean {close}?"
            print(f"{said} Waiting {PATIENCE_S:g} s for a publisher", file=sys.stderr, flush=True)

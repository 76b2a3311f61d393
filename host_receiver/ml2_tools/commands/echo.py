"""ml2-receiver echo: prints the messages of a topic."""

import argparse
import signal

from ml2_receiver.commands.options import Subparsers, add_name, add_ros_args
from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.table.reader import load_table

from .live import PATIENCE_S

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
    parser.add_argument("topic", metavar="TOPIC", help="a name without / is under /magic_leap2")
    parser.add_argument("--once", action="store_true", help="print one message and end")
    add_name(parser)
    add_ros_args(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # `| head` ends it silently
    with ros_needed():
        from ..monitoring.topic_reader import as_text, messages
    topic = options.topic
    if not topic.startswith("/"):
        prefix = load_table().sections["general"].keys["topic_name"].default
        topic = f"{'/' if options.name else ''}{options.name}{prefix}/{topic}"
    for message in messages(topic, PATIENCE_S, stopping):
        print(f"{as_text(message)}---", flush=True)
        if options.once:
            break
    return 0

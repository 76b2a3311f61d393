"""ml2-receiver record: writes what a headset sends into a rosbag2 folder."""

import argparse
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from ml2_receiver.commands.options import TOPICS, Subparsers, complete
from ml2_receiver.commands.printed_events import PrintedEvents
from ml2_receiver.commands.receiving import (
    add_options,
    config_file,
    load,
    new_server,
    ros_node,
    ros_sink,
    running,
)
from ml2_receiver.commands.session_port import SessionPort
from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.errors import RecordingError
from ml2_receiver.printable import printable
from ml2_receiver.recording.bag_folder import make_folder
from ml2_receiver.recording.mcap_file import COMPRESSIONS
from ml2_receiver.recording.options import RecordingOptions
from ml2_receiver.recording.recording import Recording, losses, summary
from ml2_receiver.topics.calibrated_sink import CalibratedSink
from ml2_receiver.topics.fan_out import FanOut

from .record_attached import record_attached
from .recording_wait import Standing, how_long, wait

_MOST = 1 << 31
_ENDED_EARLY_HINT = (
    "Leave the folder in place, and free space on its disk. Fewer streams or --compression zstd"
    " need less."
)
_EXAMPLES = """examples:
  ml2-receiver record walk                       publish in ROS 2, and record into walk/
  ml2-receiver record walk --no-ros              only record; needs no ROS 2
  ml2-receiver record walk --attach              have the `run` record that is on already
  ml2-receiver record walk --duration 60 --topic 'world_left/*' --topic /tf
  ml2-receiver record walk --compression zstd    smaller, for more CPU
  ml2-receiver record walk --split-size 4000     another file every 4 GB
  ros2 bag play walk                             in ROS 2 afterwards
  ml2-receiver play walk                         to a receiver, as the headset did

In the end it says how long the recording is from its first message to its last, and of each topic
what is missing: "dropped" arrived here and was not written, "lost before the receiver" never
arrived.

If the recording is cut off by a kill, all but the last half second is there:
`ros2 bag reindex walk -s mcap` brings its metadata.yaml up to date.
Whatever follows --ros-args goes to ROS 2."""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "record",
        help="receive a headset and record it as a rosbag2",
        epilog=_EXAMPLES,
    )
    parser.add_argument("out", type=Path, metavar="OUT", help="folder to make")
    parser.add_argument("--no-ros", action="store_true", help="record without publishing")
    parser.add_argument(
        "--attach",
        action="store_true",
        help="have a receiver on this machine record that runs, and stop it in the end; of the"
        " options below only --name, which finds it, is for this",
    )
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier recording")
    parser.add_argument(
        "--duration", type=_above_0(float), metavar="S", help="end after so many seconds"
    )
    topic = parser.add_argument(
        "--topic",
        action="append",
        default=[],
        metavar="TOPIC",
        help="record this one, a name or a pattern such as 'world_left/*'; may be repeated; config"
        " and log are recorded in any case; default: all",
    )
    complete(topic, TOPICS)
    parser.add_argument(
        "--split-size",
        type=_above_0(int),
        default=0,
        metavar="MB",
        help="begin another file when one has so many MB",
    )
    parser.add_argument(
        "--split-duration",
        type=_above_0(int),
        default=0,
        metavar="S",
        help="begin another file after so many seconds",
    )
    parser.add_argument(
        "--compression", choices=COMPRESSIONS, default="none", help="of chunks; default: none"
    )
    add_options(parser)
    parser.set_defaults(run=_run)


def _above_0[Number: (int, float)](kind: type[Number]) -> Callable[[str], Number]:
    def parse(text: str) -> Number:
        try:
            value = kind(text)
        except ValueError:
            value = kind(0)
        if not 0 < value < _MOST:
            raise argparse.ArgumentTypeError(f"expected a number above 0, found {text!r}")
        return value

    return parse


def _run(options: argparse.Namespace) -> int:
    if options.attach:
        if options.no_ros or options.overwrite:
            raise RecordingError("--attach goes neither with --no-ros nor with --overwrite")
        return record_attached(options)
    return _record(options)


def _record(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    file = config_file(options)
    config = load(file, options)
    with ExitStack() as stack:
        port = stack.enter_context(SessionPort(options))
        node = ros_node(config, options)
        if node is not None:
            stack.enter_context(node)
            config = node.config

        def fail(reason: str) -> None:
            print(f"ERROR: {_ended_early(options.out, reason)}", file=sys.stderr, flush=True)
            if options.no_ros:  # nothing else is left to do
                stopping.set()

        make_folder(options.out, is_overwriting=options.overwrite)
        sinks = FanOut([PrintedEvents()] if node is None else [])
        sink = CalibratedSink(sinks, config.calibrations)
        server = new_server(port, config, sink, is_paused=options.start_paused)
        if node is not None:
            stack.enter_context(ros_sink(node, server, file, sink, sinks))
        recording = Recording(options.out, _recording_options(options), config.prefix, sinks, fail)
        stack.callback(recording.end)
        with running(server, port):
            print(f"listening on {server.address}", flush=True)
            print(f"recording into {options.out} {how_long(options.duration)}", flush=True)

            def standing() -> Standing:
                now = recording.progress(server.report())
                return Standing(now.duration_s, now.file_bytes, now.messages, summary(now))

            wait(stopping, options.duration, standing)
        recording.end()
        progress = recording.progress(server.report())
    print(f"recorded into {options.out}: {summary(progress)}")
    for line in losses(progress):
        print(f"  {printable(line)}")
    if recording.failure is not None:
        raise RecordingError(_ended_early(options.out, recording.failure), hint=_ENDED_EARLY_HINT)
    return 0


def _recording_options(options: argparse.Namespace) -> RecordingOptions:
    return RecordingOptions(
        options.compression, tuple(options.topic), options.split_size, options.split_duration
    )


def _ended_early(out: Path, reason: str) -> str:
    return f"the recording has ended: {reason}; what was written is in {out}"

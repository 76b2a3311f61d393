"""ml2-receiver record: writes what a headset sends into a rosbag2 folder."""

import argparse
import sys
import threading
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from rich.live import Live

from ..configuration.table import load_table
from ..errors import RecordingError
from ..recording.bag_folder import make_folder
from ..recording.bag_writer import BagWriter
from ..recording.mcap_file import COMPRESSIONS
from ..recording.recorder import Progress, Recorder
from ..topics.calibrated_sink import CalibratedSink
from ..topics.fan_out import FanOut
from ..topics.sink import Sink
from .config import Subparsers
from .entrance import Entrance
from .printed_events import PrintedEvents
from .receiving import add_options, config_file, load, make_node, serving
from .stopping import stop_signal

_REDRAW_S = 0.5
_EXAMPLES = """examples:
  ml2-receiver record walk                       publish in ROS 2, and record into walk/
  ml2-receiver record walk --no-ros              only record; needs no ROS 2
  ml2-receiver record walk --compression zstd    smaller, for more CPU
  ros2 bag play walk                             in ROS 2 afterwards
  ml2-receiver play walk                         to a receiver, as the headset did

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
    parser.add_argument("--overwrite", action="store_true", help="replace an earlier recording")
    parser.add_argument(
        "--compression", choices=COMPRESSIONS, default="none", help="of chunks; default: none"
    )
    add_options(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    file = config_file(options)
    config = load(file, options)
    with ExitStack() as stack:
        entrance = stack.enter_context(Entrance(options))
        node = None if options.no_ros else make_node(config, options)
        if node is not None:
            config = node.config
            stack.callback(node.close)
        recorder = _recorder(options, config.prefix, stopping)
        stack.callback(recorder.close)
        sinks: Sequence[Sink] = [PrintedEvents() if node is None else node, recorder]
        sink = CalibratedSink(FanOut(sinks), config.calibrations)
        with serving(entrance, config, sink, is_paused=options.start_paused) as server:
            if node is not None:
                node.serve(server, file, sink.use)
            print(f"listening on {server.address}", flush=True)
            print(f"recording into {options.out} until Ctrl-C", flush=True)
            _wait(recorder, stopping)
    print(f"recorded {_line(recorder.progress)} into {options.out}")
    if recorder.failure is not None:
        raise RecordingError(_ended_early(options.out, recorder.failure))
    return 0


def _recorder(options: argparse.Namespace, prefix: str, stopping: threading.Event) -> Recorder:
    make_folder(options.out, is_overwriting=options.overwrite)

    def fail(reason: str) -> None:
        print(f"ERROR: {_ended_early(options.out, reason)}", file=sys.stderr, flush=True)
        if options.no_ros:  # nothing else is left to do
            stopping.set()

    try:
        writer = BagWriter(options.out, options.compression)
    except OSError as error:
        raise RecordingError(f"cannot record into {options.out}: {error.strerror}") from error
    return Recorder(writer, load_table(), prefix, fail)


def _ended_early(out: Path, reason: str) -> str:
    return f"the recording has ended: {reason}; what was written is in {out}"


def _wait(recorder: Recorder, stopping: threading.Event) -> None:
    if not sys.stdout.isatty():
        stopping.wait()
        return
    with Live(auto_refresh=False, transient=True) as live:
        last = recorder.progress
        while not stopping.wait(_REDRAW_S):
            now = recorder.progress
            rate = (now.file_bytes - last.file_bytes) / (now.elapsed_s - last.elapsed_s)
            live.update(f"{_line(now)}, {rate / 1e6:.1f} MB/s", refresh=True)
            last = now


def _line(progress: Progress) -> str:
    return (
        f"{progress.elapsed_s:.1f} s, {progress.file_bytes / 1e6:.1f} MB,"
        f" {progress.messages} messages, {progress.dropped} dropped"
    )

"""ml2-receiver evaluate: compares the headset's poses with poses estimated from its images."""

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.table import Table

from ml2_receiver.commands.options import Subparsers, add_ros_args
from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.commands.stopping import go_on, stop_signal

from ..errors import EvaluationError
from ..export.kalibr import CAMERAS
from .optional_packages import optional_packages
from .reading import add_headset, check_headset, say_apart, say_left_out

if TYPE_CHECKING:
    from ..evaluation.evaluation import Evaluation
    from ..evaluation.trajectory import Progress

_EPILOG = """\
Estimates the trajectory of a camera from its recorded images alone, by structure from motion with
COLMAP, which takes a few minutes. Compares the trajectory with the poses of the same camera in
/tf: error after alignment, drift, time offset, plots. Writes report.html, which needs no other
file, report.md, report.json, and both trajectories as TUM files.

examples:
  ml2-receiver record walk                         record first: walk about for 20 s
  ml2-receiver evaluate --bag walk --camera world_center
  ml2-receiver evaluate --bag walk --camera world_left --out walk-left
  ml2-receiver evaluate --bag walk --camera world_left --trajectory CameraTrajectory.txt
  ml2-receiver evaluate --live --camera world_center       while `run` runs; walk, then Ctrl-C
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "evaluate",
        help="compare the headset's poses with those that its images show",
        epilog=_EPILOG,
    )
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--bag", type=Path, help="folder that ml2-receiver record has written")
    source.add_argument(
        "--live",
        action="store_true",
        help="record from `run` until Ctrl-C, then evaluate",
    )
    add_headset(parser)
    parser.add_argument(
        "--prefix", default="/magic_leap2", help="prefix of live topics; default: /magic_leap2"
    )
    parser.add_argument("--camera", choices=CAMERAS, required=True, help="the camera to evaluate")
    parser.add_argument(
        "--trajectory",
        type=Path,
        metavar="FILE",
        help="evaluate this trajectory by ORB-SLAM3, OpenVINS or another program instead",
    )
    parser.add_argument(
        "--truth",
        type=Path,
        metavar="FILE",
        help="TUM file of the camera's true poses, if known; compared as well",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("evaluation"),
        metavar="FOLDER",
        help="where the report goes; default: evaluation. Replaces an earlier report",
    )
    add_ros_args(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.live and options.trajectory is not None:
        raise EvaluationError("--trajectory needs a recording: name it with --bag, not --live")
    if options.live:
        check_headset(options.headset)
    with optional_packages(
        "cv2", "matplotlib", command="evaluate", pip="pip install './host_receiver[evaluate]'"
    ):
        from ..evaluation.evaluation import summary
        from ..evaluation.report import table, write_report
    evaluation = _evaluation(options)
    write_report(options.out, evaluation)
    heading, *rows = table(summary(evaluation))
    shown = Table(*heading, box=None)
    for row in rows:
        shown.add_row(*row)
    Console().print(shown)
    print(f"wrote {options.out / 'report.html'}")
    return 0


def _evaluation(options: argparse.Namespace) -> "Evaluation":
    from ..evaluation.evaluation import evaluate, evaluate_estimate
    from ..evaluation.sequence import read_sequence
    from ..evaluation.slam_files import read_trajectory
    from ..evaluation.tum import read_tum

    truth = None if options.truth is None else read_tum(options.truth)
    if options.trajectory is not None:
        estimate = read_trajectory(options.trajectory)
        sequence = read_sequence(options.bag, options.camera, options.headset)
        say_apart(sequence.apart)
        say_left_out(sequence.left_out)
        name = options.trajectory.name
        return evaluate_estimate(sequence, options.camera, name, estimate, truth)
    if not options.live:
        sequence = read_sequence(options.bag, options.camera, options.headset)
        say_apart(sequence.apart)
        say_left_out(sequence.left_out)
        with _progress() as progress:
            return evaluate(sequence, options.camera, truth, progress)
    with ros_needed():
        from ..evaluation.live import record_live
    stopping = stop_signal()
    with TemporaryDirectory(prefix="ml2_evaluate_") as folder:
        print(f"recording {options.camera} until Ctrl-C", file=sys.stderr, flush=True)
        with Console(stderr=True).status("no images yet") as status:
            sequence = record_live(
                options.prefix,
                options.camera,
                Path(folder),
                stopping,
                lambda images: status.update(f"{images} images"),
            )
        go_on()
        with _progress() as progress:
            return evaluate(sequence, options.camera, truth, progress)


@contextmanager
def _progress() -> "Iterator[Progress]":
    """Shows each step on standard error: with a bar on a terminal, else in a line."""
    console = Console(stderr=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    if not console.is_terminal:
        yield _say_steps()
        return
    with Bars(*columns, console=console, transient=True) as bars:
        task = bars.add_task("")

        def show(step: str, done: int, total: int) -> None:
            begins = step != bars.tasks[0].description  # and is drawn at once, as it may be short
            bars.update(task, description=step, completed=done, total=total or None, refresh=begins)

        yield show


def _say_steps() -> "Progress":
    said: set[str] = set()

    def say(step: str, done: int, total: int) -> None:
        if step not in said:
            said.add(step)
            print(f"{step}{f' ({total})' if total else ''}", file=sys.stderr, flush=True)

    return say

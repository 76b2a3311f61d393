"""ml2-receiver evaluate: how well the headset's poses agree with those that its images show."""

import argparse
import sys
import threading
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import track
from rich.table import Table

from ml2_receiver.commands.config import Subparsers
from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.errors import EvaluationError

from ..export.kalibr import CAMERAS

if TYPE_CHECKING:
    from ..evaluation.estimator import Images
    from ..evaluation.evaluation import Evaluation

_EPILOG = """\
Estimates the trajectory from the images of a recording alone, and compares it with the poses of
the same camera in /tf: error after alignment, drift, time offset, plots. Writes report.html, which
needs no other file, report.md, report.json, and both trajectories as TUM files.
Estimators: sfm is structure from motion by COLMAP, which takes a few minutes. odometry places
images as they come; it closes no loops, so it is the less accurate one.

examples:
  ml2-receiver record walk                         record first: walk about for 20 s
  ml2-receiver evaluate --bag walk --camera world_center
  ml2-receiver evaluate --bag walk --camera world_left --out walk-left
  ml2-receiver evaluate --bag walk --camera world_left --trajectory CameraTrajectory.txt
  ml2-receiver evaluate --live --camera world_center       beside `run`; walk about, then Ctrl-C
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "evaluate",
        help="compare the headset's poses with those that images show",
        epilog=_EPILOG,
    )
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--bag", type=Path, help="folder that ml2-receiver record has written")
    source.add_argument(
        "--live", action="store_true", help="what `run` publishes, until Ctrl-C or its end"
    )
    parser.add_argument(
        "--prefix", default="/magic_leap2", help="of live topics; default: /magic_leap2"
    )
    parser.add_argument(
        "--camera", choices=CAMERAS, required=True, help="whose images are looked at"
    )
    way = parser.add_mutually_exclusive_group()
    way.add_argument(
        "--estimator",
        choices=("sfm", "odometry"),
        help="default: sfm for a recording, odometry for live images",
    )
    way.add_argument(
        "--trajectory",
        type=Path,
        metavar="FILE",
        help="what ORB-SLAM3, OpenVINS or another program made of the recording, instead",
    )
    parser.add_argument(
        "--truth",
        type=Path,
        metavar="FILE",
        help="TUM file of the camera's true poses, where they are known, to compare with as well",
    )
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("evaluation"),
        metavar="FOLDER",
        help="for the report; default: evaluation. An earlier report there is replaced",
    )
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.live and options.trajectory is not None:
        raise EvaluationError("--trajectory is of a recording: say which one by --bag")
    try:
        from ..evaluation.evaluation import summary
        from ..evaluation.report import table, write_report
    except ModuleNotFoundError as error:
        if error.name not in ("cv2", "matplotlib"):
            raise
        raise EvaluationError(
            f"evaluation needs {error.name}: pip install './host_receiver[evaluate]'"
        ) from error
    it = _evaluation(options)
    write_report(options.out, it)
    heading, *rows = table(summary(it))
    shown = Table(*heading, box=None)
    for row in rows:
        shown.add_row(*row)
    Console().print(shown)
    print(f"wrote {options.out / 'report.html'}")
    return 0


def _evaluation(options: argparse.Namespace) -> "Evaluation":
    from ..evaluation.evaluation import evaluate, judged
    from ..evaluation.sequence import read_sequence
    from ..evaluation.slam_files import read_trajectory
    from ..evaluation.tum import read_tum

    truth = None if options.truth is None else read_tum(options.truth)
    if options.trajectory is not None:
        found = read_trajectory(options.trajectory)
        sequence = read_sequence(options.bag, options.camera)
        return judged(sequence, options.camera, options.trajectory.name, found, truth)
    estimator = options.estimator or ("odometry" if options.live else "sfm")
    if not options.live:
        return evaluate(options.bag, options.camera, estimator, truth, partial(_watched, estimator))
    with ros_needed():
        from ..evaluation.live import evaluate_live
    watched = partial(_watched_live, stop_signal())
    it, dropped = evaluate_live(options.prefix, options.camera, estimator, truth, watched)
    if dropped:
        print(f"WARNING: {estimator} was too slow for {dropped} images", file=sys.stderr)
    return it


def _watched(estimator: str, images: "Images", count: int) -> "Images":
    """Says how far the reading is, and then that the rest takes its time."""
    console = Console(stderr=True)
    yield from track(images, "reading images", total=count, console=console, transient=True)
    if estimator == "sfm":
        print("estimating the trajectory, for some minutes", file=sys.stderr, flush=True)


def _watched_live(stopping: threading.Event, images: "Images") -> "Images":
    """Until Ctrl-C, or until no more come."""
    print("estimating until Ctrl-C", file=sys.stderr, flush=True)
    console = Console(stderr=True)
    for image in track(images, "images", total=None, console=console, transient=True):
        if stopping.is_set():
            return
        yield image

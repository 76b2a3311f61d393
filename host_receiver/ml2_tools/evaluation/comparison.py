"""Compares an estimated trajectory with a reference by the programs evo_ape and evo_rpe of evo.

evo is under the GPL: it runs in separate processes and is never imported.
"""

import io
import json
import os
import shutil
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from ..errors import EvaluationError
from .trajectory import Trajectory
from .tum import write_tum

LONGEST_DIFFERENCE_S = 0.01
STATISTICS = ("rmse", "mean", "median", "std", "min", "max")
_TIMEOUT_S = 300
# evo_rpe computes errors per metre only on a longer path.
_SHORTEST_M = 1.2
_MISSING = "evaluation needs evo: pip install './host_receiver[evaluate]'"

type Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """The errors of an estimate after a Sim(3) alignment with the reference.

    Two poses match if their stamps are at most LONGEST_DIFFERENCE_S apart.

    Attributes:
        ape_m: statistics of the distance between positions: rmse, mean, median, std, min, max.
        rpe_m: the same statistics of the position error per metre of the reference path; empty
            if the path is too short.
        rpe_deg: the same statistics of the rotation error per metre.
        matched_pairs: the number of matched poses.
        reference_path_m, estimate_path_m: the path lengths through the matched poses.
        stamps_s: the stamps of the estimate's matched poses.
        errors_m: the position error of each matched pose.
        alignment: 4x4, from the estimate's world and scale to the reference's.
    """

    ape_m: dict[str, float]
    rpe_m: dict[str, float]
    rpe_deg: dict[str, float]
    matched_pairs: int
    reference_path_m: float
    estimate_path_m: float
    stamps_s: Floats
    errors_m: Floats
    alignment: Floats


def compare(reference: Trajectory, estimate: Trajectory) -> Comparison:
    """Runs evo_ape and evo_rpe.

    Raises:
        EvaluationError: evo is missing, or it cannot compare them because, say, no stamps match.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_tum(folder / "reference.tum", reference)
        write_tum(folder / "estimate.tum", estimate)
        ape = _run_evo("evo_ape", folder)
        per_metre = ("--delta", "1", "--delta_unit", "m", "--all_pairs", "--pose_relation")
        path_m = float(ape.arrays["distances_from_start"][-1])
        rpe_m, rpe_deg = (
            _run_evo("evo_rpe", folder, *per_metre, part).statistics if path_m > _SHORTEST_M else {}
            for part in ("trans_part", "angle_deg")
        )
    return Comparison(
        ape_m=ape.statistics,
        rpe_m=rpe_m,
        rpe_deg=rpe_deg,
        matched_pairs=len(ape.arrays["error_array"]),
        reference_path_m=path_m,
        estimate_path_m=float(ape.arrays["distances"][-1]),
        stamps_s=ape.arrays["timestamps"],
        errors_m=ape.arrays["error_array"],
        alignment=ape.arrays["alignment_transformation_sim3"],
    )


@dataclass(frozen=True)
class _Result:
    """The content of the file that evo writes with --save_results."""

    statistics: dict[str, float]
    arrays: dict[str, Floats]


def _run_evo(program: str, folder: Path, *options: str) -> _Result:
    """Runs an evo program on the two files in `folder`.

    HOME is `folder` too, so that evo keeps its settings there and does not read the user's.
    """
    search_path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    path = shutil.which(program, path=search_path)
    if path is None:
        raise EvaluationError(_MISSING)
    result = folder / f"{program}.zip"
    command = [path, "tum", "reference.tum", "estimate.tum", "--align", "--correct_scale"]
    command += ["--t_max_diff", str(LONGEST_DIFFERENCE_S), "--no_warnings", *options]
    run = subprocess.run(
        [*command, "--save_results", str(result)],
        cwd=folder,
        env=os.environ | {"HOME": str(folder), "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        timeout=_TIMEOUT_S,
        check=False,
    )
    if run.returncode or not result.exists():
        last_line = (run.stderr or run.stdout).strip().splitlines()[-1:]
        raise EvaluationError(f"{program} cannot compare the trajectories: {' '.join(last_line)}")
    return _read(result)


def _read(path: Path) -> _Result:
    with zipfile.ZipFile(path) as archive:
        statistics = json.loads(archive.read("stats.json"))
        arrays = {
            name.removesuffix(".npy"): np.load(io.BytesIO(archive.read(name)), allow_pickle=False)
            for name in archive.namelist()
            if name.endswith(".npy")
        }
    return _Result({name: float(statistics[name]) for name in STATISTICS}, arrays)

"""How far an estimated trajectory is from a reference, by the programs of evo.

evo is under the GPL: it runs as processes of its own and is never imported.
"""

from __future__ import annotations

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

from ml2_receiver.errors import EvaluationError

from .trajectory import Trajectory
from .tum import write_tum

LONGEST_DIFFERENCE_S = 0.01
STATISTICS = ("rmse", "mean", "median", "std", "min", "max")
_TIMEOUT_S = 300
# What the errors per metre need.
_SHORTEST_M = 1.2
_MISSING = "evaluation needs evo: pip install './host_receiver[evaluate]'"

type Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """Of poses whose stamps are at most LONGEST_DIFFERENCE_S apart, after a Sim(3) alignment.

    Attributes:
        ape_m: statistics of the distance between positions: rmse, mean, median, std, min, max.
        rpe_m: of the error in position over each metre of the reference, if it has a metre.
        rpe_deg: of that in direction.
        matched_pairs: how many there are.
        reference_path_m, estimate_path_m: lengths of both ways through the matched poses.
        stamps_s: of the matched poses of the estimate.
        errors_m: the distance of each.
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
        EvaluationError: evo is missing, or cannot compare these, as when no stamps match.
    """
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_tum(folder / "reference.tum", reference)
        write_tum(folder / "estimate.tum", estimate)
        ape = _run_evo("evo_ape", folder)
        per_metre = ("--delta", "1", "--delta_unit", "m", "--all_pairs", "--pose_relation")
        path_m = float(ape.arrays["distances_from_start"][-1])
        rpe_m, rpe_deg = (
            _run_evo("evo_rpe", folder, *per_metre, of).statistics if path_m > _SHORTEST_M else {}
            for of in ("trans_part", "angle_deg")
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
    """What --save_results has."""

    statistics: dict[str, float]
    arrays: dict[str, Floats]


def _run_evo(program: str, folder: Path, *options: str) -> _Result:
    """`folder` is evo's home too: it writes its settings there, and finds none of the user's."""
    beside = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    path = shutil.which(program, path=beside)
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
        said = (run.stderr or run.stdout).strip().splitlines()[-1:]
        raise EvaluationError(f"{program} cannot compare the trajectories: {' '.join(said)}")
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

"""`make validate`: estimates trajectories of known length from simulated and recorded images.

SEED= draws two of them. Writes build/validate/report.json and report.md, and each evaluation's own
report beside them.
"""

import json
import logging
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from faults import FAULTS, inject
from processes import EXCERPT, RECEIVER, ROOT
from recorded_excerpt import evaluate_excerpt
from simulated_walk import stream
from tables import page
from walks import WALKS, Walk, drawn_walks

_OUT = ROOT / "build" / "validate"
# The faults are injected into the shortest walk.
_FAULTY = WALKS[1]


def main() -> None:
    shutil.rmtree(_OUT, ignore_errors=True)
    _OUT.mkdir(parents=True)
    entries = []
    for entry in _entries(int(sys.argv[1])):
        entries.append(entry)
        (_OUT / "report.json").write_text(json.dumps(entries, indent=2) + "\n")
        (_OUT / "report.md").write_text(page(entries))
        rmse_cm = entry["rmse_m"] * 100
        matched = f"{entry['matched_pairs']} of {entry['images_sent']} images matched"
        logging.info(f"{entry['trajectory']}: {rmse_cm:.2f} cm rmse, {matched}")
    print((_OUT / "report.md").read_text())


def _entries(seed: int) -> Iterator[dict[str, Any]]:
    for number, walk in enumerate(WALKS + drawn_walks(seed)):
        yield _evaluated_walk(walk, _OUT / f"walk_{number + 1}")
    faulty = _OUT / f"walk_{WALKS.index(_FAULTY) + 1}"
    for number, (name, fault) in enumerate(FAULTS.items()):
        logging.info(f"{_FAULTY.name}, {name}")
        out = _OUT / f"fault_{number + 1}"
        inject(fault, _FAULTY.camera, faulty / "bag", out / "bag")
        figures = evaluate(out, _FAULTY.camera, faulty / "truth.tum")
        yield _entry(_FAULTY.name, figures) | {"fault": name}
        shutil.rmtree(out / "bag")
    for bag in _OUT.glob("walk_*/bag"):
        shutil.rmtree(bag)
    if EXCERPT.is_dir():
        logging.info("the recorded excerpt")
        yield evaluate_excerpt(_OUT / "euroc")
    else:
        logging.info(f"no recorded excerpt at {EXCERPT}")


def _evaluated_walk(walk: Walk, folder: Path) -> dict[str, Any]:
    logging.info(f"{walk.name}: streaming")
    walked = stream(walk, folder)
    logging.info(f"{walk.name}: evaluating")
    figures = evaluate(folder, walk.camera, walked.truth)
    return _entry(walk.name, figures | {"images_sent": walked.images_sent, "walked": walked.walked})


def evaluate(folder: Path, camera: str, truth: Path | None = None) -> dict[str, Any]:
    """Runs `ml2-receiver evaluate` and returns the figures in its report."""
    command: list[str | Path] = [RECEIVER, "evaluate", "--bag", folder / "bag", "--camera", camera]
    command += ["--out", folder / "evaluation"]
    if truth is not None:
        command += ["--truth", truth]
    with (folder / "evaluate.log").open("w") as log:
        subprocess.run(command, check=True, stdout=log, stderr=subprocess.STDOUT)
    figures: dict[str, Any] = json.loads((folder / "evaluation" / "report.json").read_text())
    return figures


def _entry(name: str, figures: dict[str, Any]) -> dict[str, Any]:
    return {"trajectory": name} | {key: figures[key] for key in figures if key != "recording"}


if __name__ == "__main__":
    logging.basicConfig(format="[%(asctime)s] %(message)s", datefmt="%H:%M:%S", level=logging.INFO)
    main()

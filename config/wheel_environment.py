"""A virtual environment of a wheel and nothing but what it, or one of its extras, requires.

Requirements are links to the packages of the Python that runs this, so that no network is needed
and their versions are those that the tests use.
"""

import os
import subprocess
import sys
import venv
from importlib.metadata import Distribution, distribution, distributions
from pathlib import Path

from packaging.requirements import Requirement


def make(folder: Path, wheel: Path, extra: str = "") -> Path:
    """Makes the environment in a folder that is not there yet; returns its bin/python."""
    venv.create(folder, symlinks=True)
    python = folder / "bin" / "python"
    install = ["--quiet", "--no-deps", "--no-index", f"--find-links={wheel.parent}"]
    name = wheel.name.partition("-")[0]
    pip = [sys.executable, "-m", "pip", "--python", str(python)]
    # PYTHONPATH may lead to the sources, whose metadata pip would take for an installation.
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    subprocess.run([*pip, "install", *install, name], check=True, env=environment)
    (packages,) = folder.glob("lib/python*/site-packages")
    (installed,) = distributions(path=[str(packages)])
    for needed in _closure(installed, extra).values():
        for entry in {Path(file).parts[0] for file in needed.files or ()} - {"..", "__pycache__"}:
            if not (packages / entry).exists():
                (packages / entry).symlink_to(Path(str(needed.locate_file(entry))))
    return python


def _closure(root: Distribution, extra: str) -> dict[str, Distribution]:
    """All that a distribution requires, by name; `extra` is one of its own, or empty."""
    found: dict[str, Distribution] = {}
    open_requirements = list(root.requires or ())
    while open_requirements:
        requirement = Requirement(open_requirements.pop())
        marker = requirement.marker
        if requirement.name in found or (marker and not marker.evaluate({"extra": extra})):
            continue
        found[requirement.name] = distribution(requirement.name)
        open_requirements += found[requirement.name].requires or ()
    return found

"""ml2-receiver calibrate: finds how the headset's inertial units are mounted."""

import argparse
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from ml2_receiver.commands.options import Subparsers
from ml2_receiver.configuration.mounts import Mount, load_mounts, mounts_file, save_mounts
from ml2_receiver.errors import CalibrationError

from ..bags.bag_reader import BagReader
from .optional_packages import optional_packages
from .reading import add_headset, progress, say_apart, say_left_out

if TYPE_CHECKING:
    from ..calibration.imu import Estimate

_EPILOG = """\
Compares the poses of the head with gyroscope and accelerometer of each unit, and saves rotation,
position, time offset and biases. From its next start, `run` publishes the poses on /tf_static.
`export --bag` with --imu writes them. No target is needed: move the head for a minute, turn it
about all three axes, and walk about.

examples:
  ml2-receiver record motion --duration 60     while you nod, shake and tilt the head, and walk
  ml2-receiver calibrate imu --bag motion
  ml2-receiver calibrate imu --forget
"""
_KNOWN_LIMITS = """\
The headset's poses are themselves filtered from these units, so the time offset contains the delay
of that filter. The compute pack is not rigid with the head, and is left out."""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "calibrate",
        help="find how the inertial units are mounted, from a minute of motion",
        epilog=_EPILOG,
    )
    parser.add_argument("what", choices=["imu"], help="what to calibrate")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--bag", type=Path, help="folder that ml2-receiver record has written")
    source.add_argument(
        "--forget", action="store_true", help="delete what was found for all headsets"
    )
    add_headset(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.forget:
        save_mounts({})
        print(f"forgot the inertial units in {mounts_file()}")
        return 0
    with optional_packages(
        "scipy", command="calibrate", pip="pip install './host_receiver[calibrate]'"
    ):
        from ..calibration.imu import estimate_mount
        from ..calibration.recorded_motion import read_motion

    known = load_mounts()
    reader = BagReader(options.bag, options.headset)
    if not (device := reader.config.device_id):
        raise CalibrationError(
            "the recording does not say which headset it is of",
            hint="It is of an earlier version: record again.",
        )
    with progress(reader, "reading") as on_bytes:
        motions = read_motion(reader, on_bytes)
    say_apart(reader.apart)
    say_left_out(reader.left_out)
    found = {}
    console = Console(stderr=True)
    for unit, motion in motions.items():
        with console.status(f"fitting {unit}"):
            try:
                found[unit] = estimate_mount(motion)
            except CalibrationError as error:
                raise CalibrationError(f"{unit}: {error}", hint=error.hint) from error
    _print(found)
    save_mounts({**known, device: {unit: _mount(it) for unit, it in found.items()}})
    print(_KNOWN_LIMITS)
    print(f"wrote {mounts_file()}; `run` publishes it on /tf_static from its next start")
    return 0


def _print(found: Mapping[str, "Estimate"]) -> None:
    table = Table("", *found, box=None)
    columns = found.values()
    table.add_row(
        "x, y, z",
        *(_shown(1e3 * it.translation_m, 1e3 * it.translation_sigma_m, 1, " mm") for it in columns),
    )
    table.add_row(
        "roll, pitch, yaw",
        *(
            _shown(
                it.rotation.as_euler("xyz", degrees=True), np.degrees(it.rotation_sigma_rad), 2, "°"
            )
            for it in columns
        ),
    )
    table.add_row(
        "time offset",
        *(
            _shown([1e3 * it.time_offset_s], [1e3 * it.time_offset_sigma_s], 2, " ms")
            for it in columns
        ),
    )
    Console().print(table)
    print("in head_frame (x forward, y left, z up); ± is one standard deviation")


def _shown(values: Iterable[float], sigmas: Iterable[float], decimals: int, unit: str) -> str:
    numbers = ", ".join(f"{round(it, decimals) + 0.0:.{decimals}f}" for it in values)  # no -0.0
    return f"{numbers}{unit} ± {max(sigmas):.{decimals + 1}f}"


def _mount(estimate: "Estimate") -> Mount:
    return Mount(
        translation_m=_numbers(estimate.translation_m),
        rotation=_numbers(estimate.rotation.as_quat(canonical=True)),
        time_offset_s=estimate.time_offset_s,
        gyroscope_bias=_numbers(estimate.gyroscope_bias),
        accelerometer_bias=_numbers(estimate.accelerometer_bias),
        translation_sigma_m=_numbers(estimate.translation_sigma_m),
        rotation_sigma_deg=_numbers(np.degrees(estimate.rotation_sigma_rad)),
        time_offset_sigma_s=estimate.time_offset_sigma_s,
        calibrated=datetime.now(UTC).isoformat(timespec="seconds"),
    )


def _numbers(values: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(map(float, values))

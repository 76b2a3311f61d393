"""ml2-receiver export: what the receiver publishes, in the files of other programs."""

import argparse
from pathlib import Path

from ..configuration.table import load_table
from ..errors import ExportError
from ..export.kalibr import CAMERAS, ImuNoise, camchain, imu
from .config import Subparsers
from .ros_start import ros_needed

_IMUS = ("imu_left", "imu_right", "imu_compute_pack")
_PATIENCE_S = 10.0
_NOISE = {
    "accelerometer_noise_density": "m/s^2/sqrt(Hz)",
    "accelerometer_random_walk": "m/s^3/sqrt(Hz)",
    "gyroscope_noise_density": "rad/s/sqrt(Hz)",
    "gyroscope_random_walk": "rad/s^2/sqrt(Hz)",
}
_EPILOG = """\
Needs a running `ml2-receiver run` with a headset, or a bag that is played.

examples:
  ml2-receiver export --kalibr calibration
  ml2-receiver export --kalibr calibration --cameras world_left world_right --imu imu_left \\
    --accelerometer-noise-density 0.002 --accelerometer-random-walk 0.0003 \\
    --gyroscope-noise-density 0.0002 --gyroscope-random-walk 0.00002

Noise of the IMUs is nowhere documented: take it from your own Allan deviation.
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "export",
        help="write cameras and their places as Kalibr YAML",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "--kalibr",
        type=Path,
        metavar="FOLDER",
        required=True,
        help="where camchain.yaml and imu.yaml go; files that are there are not replaced",
    )
    parser.add_argument(
        "--prefix", default="/magic_leap2", help="of the topics; default: /magic_leap2"
    )
    parser.add_argument(
        "--cameras",
        nargs="+",
        choices=CAMERAS,
        default=[],
        metavar="CAMERA",
        help=f"cam0, cam1, ...; default: those that run of {', '.join(CAMERAS)}",
    )
    parser.add_argument("--imu", choices=_IMUS, help="write imu.yaml too; needs its noise")
    for name, unit in _NOISE.items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=float, metavar="X", help=unit)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    noise = _noise(options)
    with ros_needed():
        from ..export.live_rig import look
    rig = look(options.prefix, options.cameras, options.imu, _PATIENCE_S)
    texts = {"camchain.yaml": camchain(rig.cameras)}
    if noise is not None and rig.imu_rate_hz is not None:
        (topic,) = load_table().streams[options.imu].topics
        texts["imu.yaml"] = imu(topic.full_name(options.prefix), rig.imu_rate_hz, noise)
    _write(options.kalibr, texts)
    print("T_cam_imu is not in camchain.yaml: the headset does not say where its IMUs are.")
    print("kalibr_calibrate_imu_camera finds it from a recording.")
    return 0


def _noise(options: argparse.Namespace) -> ImuNoise | None:
    values = {name: getattr(options, name) for name in _NOISE}
    if options.imu is None:
        given = [_option(name) for name, value in values.items() if value is not None]
        if given:
            raise ExportError(f"{given[0]} is of an IMU: say which one by --imu")
        return None
    for name, value in values.items():
        if value is None or not 0 < value < float("inf"):
            expected = f"expected {_option(name)} with --imu, above 0, in {_NOISE[name]}"
            raise ExportError(f"{expected}, found {'nothing' if value is None else value}")
    return ImuNoise(**values)


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _write(folder: Path, texts: dict[str, str]) -> None:
    """All of them, or none where one is there already."""
    existing = [folder / name for name in texts if (folder / name).exists()]
    if existing:
        raise ExportError(f"{existing[0]} is there already")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (folder / name).write_text(text, "utf-8")
            print(f"wrote {folder / name}")
    except OSError as error:
        raise ExportError(f"{folder} cannot be written: {error.strerror}") from error

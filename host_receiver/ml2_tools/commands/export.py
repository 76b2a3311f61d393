"""ml2-receiver export: writes cameras or a recording in the formats of other programs."""

import argparse
from functools import partial
from pathlib import Path

from ml2_receiver.commands.options import Subparsers, add_ros_args
from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.configuration.mounts import load_mounts
from ml2_receiver.table.reader import load_table

from ..bags.bag_reader import BagReader
from ..errors import ExportError
from ..export import basalt, open_vins, orb_slam3, vins_fusion
from ..export.kalibr import CAMERAS, ImuNoise, MountedImu, Mounting, camchain, imu
from ..export.rig import Rig
from ..geometry.pose import pose_from
from .live import PATIENCE_S
from .optional_packages import optional_packages
from .reading import add_headset, check_headset, progress, say_apart, say_left_out

_IMUS = ("imu_left", "imu_right", "imu_compute_pack")
_NOISE = {
    "accelerometer_noise_density": "m/s^2/sqrt(Hz)",
    "accelerometer_random_walk": "m/s^3/sqrt(Hz)",
    "gyroscope_noise_density": "rad/s/sqrt(Hz)",
    "gyroscope_random_walk": "rad/s^2/sqrt(Hz)",
}
_EPILOG = """\
--kalibr reads a recording with --bag, otherwise the topics of a running `ml2-receiver run` with a
headset or of a bag that is played. --euroc needs --bag. It also writes settings for ORB-SLAM3 and,
with --imu, for OpenVINS. If `calibrate imu` knows the IMU, they have its place, and there are
settings for VINS-Fusion and Basalt. They are for the first camera, or for the first two as a pair.
`evaluate --trajectory` reads trajectories of such programs. --tum writes RGB-D data: depth is as
the camera would see it, and has its stamp.

examples:
  ml2-receiver export --kalibr calibration
  ml2-receiver export --kalibr calibration --bag walk
  ml2-receiver export --euroc data --bag walk --cameras world_left
  ml2-receiver export --tum data --bag walk
  ml2-receiver export --kalibr calibration --cameras world_left world_right --imu imu_left \\
    --accelerometer-noise-density 0.002 --accelerometer-random-walk 0.0003 \\
    --gyroscope-noise-density 0.0002 --gyroscope-random-walk 0.00002

The noise of the IMUs is not documented: measure it, for example by an Allan deviation.
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "export",
        help="write cameras for Kalibr, or a recording in EuRoC's format",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "--kalibr",
        type=Path,
        metavar="FOLDER",
        help="where camchain.yaml and imu.yaml go; existing files are not replaced",
    )
    parser.add_argument(
        "--euroc", type=Path, metavar="FOLDER", help="where mav0 goes, with images and IMU"
    )
    parser.add_argument(
        "--tum",
        type=Path,
        metavar="FOLDER",
        help="where one camera's undistorted images, its depth and its poses go; default: color",
    )
    parser.add_argument("--bag", type=Path, metavar="BAG", help="folder that `record` made")
    add_headset(parser)
    parser.add_argument(
        "--prefix", default="/magic_leap2", help="prefix of live topics; default: /magic_leap2"
    )
    parser.add_argument(
        "--cameras",
        nargs="+",
        choices=CAMERAS,
        default=[],
        metavar="CAMERA",
        help=f"cam0, cam1, ... in this order; default: all that run of {', '.join(CAMERAS)}",
    )
    parser.add_argument("--imu", choices=_IMUS, help="write this IMU too; needs its noise values")
    for name, unit in _NOISE.items():
        parser.add_argument(f"--{name.replace('_', '-')}", type=float, metavar="X", help=unit)
    add_ros_args(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    _check(options)
    noise = _noise(options)
    if options.bag is None:
        check_headset(options.headset)
    reader = None if options.bag is None else BagReader(options.bag, options.headset)
    if options.kalibr is not None or options.euroc is not None:
        _export_rig(options, reader, noise)
    if reader is not None:
        if options.tum is not None:
            _export_tum(options, reader)
        say_apart(reader.apart)
        say_left_out(reader.left_out)
    return 0


def _check(options: argparse.Namespace) -> None:
    if options.kalibr is options.euroc is options.tum is None:
        raise ExportError("expected --kalibr, --euroc or --tum FOLDER, found none")
    for name in ("euroc", "tum"):
        if getattr(options, name) is not None and options.bag is None:
            raise ExportError(f"--{name} needs a recording: name it with --bag")
    if options.tum is not None and len(options.cameras) > 1:
        found = " ".join(options.cameras)
        raise ExportError(f"--tum takes one camera, found {found}: name one with --cameras")


def _export_rig(
    options: argparse.Namespace, reader: BagReader | None, noise: ImuNoise | None
) -> None:
    rig = _rig(options, reader)
    prefix = options.prefix if reader is None else reader.prefix
    topic = None
    if options.imu is not None:
        (imu_topic,) = load_table().streams[options.imu].topics
        topic = imu_topic.full_name(prefix)
    if options.kalibr is not None:
        _export_kalibr(options.kalibr, rig, topic, noise)
    if reader is not None and options.euroc is not None:
        _export_euroc(options.euroc, reader, rig, topic, noise)


def _rig(options: argparse.Namespace, reader: BagReader | None) -> Rig:
    if reader is not None:
        from ..export.recorded_rig import read_rig

        mounting = _mounting(options.imu, reader.config.device_id)
        return read_rig(reader, options.cameras, options.imu, mounting)
    with ros_needed():
        from ..export.live_rig import read_live_rig
    mounting_of = partial(_mounting, options.imu)
    return read_live_rig(options.prefix, options.cameras, options.imu, mounting_of, PATIENCE_S)


def _mounting(imu: str | None, device_id: str) -> Mounting | None:
    """Returns the calibrated mounting of the IMU in the head, if there is one of the headset."""
    mount = load_mounts().get(device_id, {}).get(imu or "")
    if mount is None:
        return None
    return Mounting(pose_from(mount.translation_m, mount.rotation), mount.time_offset_s)


def _export_kalibr(folder: Path, rig: Rig, topic: str | None, noise: ImuNoise | None) -> None:
    texts = {"camchain.yaml": camchain(rig.cameras, rig.mounting)}
    if noise is not None and topic is not None and rig.imu_rate_hz is not None:
        texts["imu.yaml"] = imu(topic, rig.imu_rate_hz, noise)
    _write(folder, texts)
    if rig.mounting is None:
        print("T_cam_imu is not in camchain.yaml: the headset does not publish its IMUs' poses.")
        print("`calibrate imu` finds them from a recording, and --imu then writes them.")


def _export_euroc(
    folder: Path, reader: BagReader, rig: Rig, topic: str | None, noise: ImuNoise | None
) -> None:
    with optional_packages(
        "cv2", command="export --euroc", pip="pip install './host_receiver[products]'"
    ):
        from ..export.euroc import write_euroc
    with progress(reader, "writing") as on_bytes:
        stamps_ns, *_ = write_euroc(folder, reader, rig, topic, noise, on_bytes)
    print(f"wrote {folder / 'mav0'}")
    rate_hz = round((len(stamps_ns) - 1) / ((stamps_ns[-1] - stamps_ns[0]) / 1e9))
    texts = {"orb_slam3_times.txt": orb_slam3.times(stamps_ns)}
    pair, known = rig.cameras[:2], None
    if noise is not None and topic is not None and rig.imu_rate_hz is not None:
        texts["estimator_config.yaml"] = open_vins.estimator_config(len(pair))
        texts[open_vins.IMU_CHAIN] = open_vins.imu_chain(topic, rig.imu_rate_hz, noise)
        if rig.mounting is not None:
            known = MountedImu(topic, rig.imu_rate_hz, noise, rig.mounting)
            texts[open_vins.CAMERA_CHAIN] = open_vins.camera_chain(pair, known.mounting)
            texts |= vins_fusion.files(pair, known)
            if all(it.calibration.model == "equidistant" for it in pair):
                texts["basalt.json"] = basalt.calibration(pair, known)
    texts["orb_slam3.yaml"] = orb_slam3.settings(pair, rate_hz, known)
    _write(folder, texts)


def _export_tum(options: argparse.Namespace, reader: BagReader) -> None:
    with optional_packages(
        "cv2", command="export --tum", pip="pip install './host_receiver[products]'"
    ):
        from ..export.tum_rgbd import write_tum_rgbd
    (camera,) = options.cameras or ["color"]
    with progress(reader, "writing") as on_bytes:
        images, depths = write_tum_rgbd(options.tum, options.bag, reader, camera, on_bytes)
    print(f"wrote {options.tum}: {images} images of {camera}, {depths} with depth")


def _noise(options: argparse.Namespace) -> ImuNoise | None:
    values = {name: getattr(options, name) for name in _NOISE}
    if options.imu is None:
        given = [_option(name) for name, value in values.items() if value is not None]
        if given:
            raise ExportError(f"{given[0]} needs an IMU: name it with --imu")
        return None
    for name, value in values.items():
        if value is None or not 0 < value < float("inf"):
            expected = f"expected {_option(name)} with --imu, above 0, in {_NOISE[name]}"
            raise ExportError(f"{expected}, found {'nothing' if value is None else value}")
    return ImuNoise(**values)


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _write(folder: Path, texts: dict[str, str]) -> None:
    """Writes all files, or none if one of them exists already."""
    existing = [folder / name for name in texts if (folder / name).exists()]
    if existing:
        raise ExportError(f"{existing[0]} exists already: choose another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (folder / name).write_text(text, "utf-8")
            print(f"wrote {folder / name}")
    except OSError as error:
        raise ExportError(f"{folder} cannot be written: {error.strerror}") from error

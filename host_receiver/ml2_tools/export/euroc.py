"""Converts a recording to a folder in the EuRoC (ASL) format, which visual-inertial programs read.

Format: https://projects.asl.ethz.ch/datasets/doku.php?id=kmavvisualinertialdatasets
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ml2_receiver.private_files import make_private_folder, write_private_file
from ml2_receiver.topics.stamps import header_stamp_ns

from ..bags.bag_reader import BagReader
from ..bags.decoding import decoder
from ..errors import ExportError
from ..geometry.pose import Pose
from ..images.pixels import pixels_of
from .asl_yaml import asl_yaml
from .kalibr import ImuNoise, RigCamera, distortion
from .png_files import PngFiles
from .rig import Rig, add_rising, rate_hz

_IMU = "sensor_msgs/msg/Imu"
_IMU_COLUMNS = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
_IMU_COLUMNS += "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"


def write_euroc(
    folder: Path,
    reader: BagReader,
    rig: Rig,
    imu_topic: str | None,
    noise: ImuNoise | None,
    on_bytes: Callable[[int], None] = lambda _: None,
) -> list[list[int]]:
    """Writes FOLDER/mav0 with cam0, cam1 and so on, and imu0 if there is an `imu_topic`.

    The body frame is the optical frame of cam0. Without a calibrated IMU, imu0/sensor.yaml has no
    T_BS.

    Args:
        folder: must not contain mav0 yet.
        on_bytes: is called with each payload's length.

    Returns:
        The stamps in ns of each camera's images.

    Raises:
        ExportError: mav0 exists already or cannot be written, or a message does not fit the
            format.
        RecordingError: the recording is broken.
    """
    root = folder / "mav0"
    if root.exists():
        raise ExportError(f"{root} exists already: choose another folder")
    try:
        with PngFiles() as files:
            cameras = {
                it.topic: _ImageFolder(root / f"cam{number}", it.topic, reader, files)
                for number, it in enumerate(rig.cameras)
            }
            imu = _ImuFolder(root / "imu0") if imu_topic is not None else None
            for message in reader.messages():
                try:
                    if message.topic in cameras:
                        cameras[message.topic].add(message.payload)
                    elif imu is not None and message.topic == imu_topic:
                        imu.add(message.payload)
                except ValueError as error:
                    raise ExportError(f"{message.topic}: {error}") from error
                on_bytes(len(message.payload))
        for camera in rig.cameras:
            cameras[camera.topic].close(camera, rig)
        if imu is not None:
            imu.close(noise, rig)
    except OSError as error:
        raise ExportError(f"{root} cannot be written: {error.strerror}") from error
    return [it.stamps_ns for it in cameras.values()]


def _matrix(pose: Pose) -> dict[str, Any]:
    return {"cols": 4, "rows": 4, "data": pose.ravel().tolist()}


class _Folder:
    """The folder of one sensor, with data.csv and sensor.yaml; stamps must rise."""

    def __init__(self, folder: Path, columns: str) -> None:
        make_private_folder(folder)
        self.folder = folder
        self.stamps_ns: list[int] = []
        self._rows = [columns]

    def row(self, at_ns: int, text: str) -> None:
        add_rising(self.stamps_ns, at_ns)
        self._rows.append(f"{at_ns},{text}")

    def write(self, sensor: dict[str, Any]) -> None:
        write_private_file(self.folder / "data.csv", "\n".join((*self._rows, "")).encode())
        write_private_file(self.folder / "sensor.yaml", asl_yaml(sensor).encode())

    def rate_hz(self) -> int:
        if (found := rate_hz(self.stamps_ns)) is None:
            raise ExportError(f"expected two messages or more for {self.folder.name}")
        return max(1, round(found))


class _ImageFolder(_Folder):
    def __init__(self, folder: Path, topic: str, reader: BagReader, files: PngFiles) -> None:
        super().__init__(folder, "#timestamp [ns],filename")
        make_private_folder(folder / "data")
        self._topic, self._type, self._files = topic, reader.types.get(topic, ""), files

    def add(self, payload: bytes) -> None:
        message = decoder(self._type)(payload)
        at_ns = header_stamp_ns(message.header)
        self.row(at_ns, f"{at_ns}.png")
        path = self.folder / "data" / f"{at_ns}.png"
        self._files.write(path, self._topic, lambda: pixels_of(message))

    def close(self, camera: RigCamera, rig: Rig) -> None:
        calibration = camera.calibration
        k = calibration.k
        model, coefficients, residual_px = distortion(calibration)
        in_body = np.linalg.inv(rig.cameras[0].pose) @ camera.pose
        comment = camera.topic
        if residual_px:
            comment += f"; without k3, the lens is off by {residual_px:.3g} px"
        self.write(
            {
                "sensor_type": "camera",
                "comment": comment,
                "T_BS": _matrix(in_body),
                "rate_hz": self.rate_hz(),
                "resolution": [calibration.width, calibration.height],
                "camera_model": "pinhole",
                "intrinsics": [k[0], k[4], k[2], k[5]],
                "distortion_model": {"radtan": "radial-tangential"}.get(model, model),
                "distortion_coefficients": coefficients,
            }
        )


class _ImuFolder(_Folder):
    def __init__(self, folder: Path) -> None:
        super().__init__(folder, _IMU_COLUMNS)

    def add(self, payload: bytes) -> None:
        message = decoder(_IMU)(payload)
        w, a = message.angular_velocity, message.linear_acceleration
        numbers = (w.x, w.y, w.z, a.x, a.y, a.z)
        if not np.isfinite(numbers).all():
            raise ValueError(f"expected finite numbers, found {numbers}")
        self.row(header_stamp_ns(message.header), ",".join(map(repr, numbers)))

    def close(self, noise: ImuNoise | None, rig: Rig) -> None:
        """Writes the files; noise has EuRoC's names in sensor.yaml."""
        sensor: dict[str, Any] = {"sensor_type": "imu", "rate_hz": self.rate_hz()}
        if rig.mounting is None:
            sensor["comment"] = "T_BS is not known"
        else:
            sensor["T_BS"] = _matrix(np.linalg.inv(rig.cameras[0].pose) @ rig.mounting.pose)
        if noise is not None:
            sensor |= {
                "gyroscope_noise_density": noise.gyroscope_noise_density,
                "gyroscope_random_walk": noise.gyroscope_random_walk,
                "accelerometer_noise_density": noise.accelerometer_noise_density,
                "accelerometer_random_walk": noise.accelerometer_random_walk,
            }
        self.write(sensor)

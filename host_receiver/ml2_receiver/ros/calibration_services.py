"""Services with which ROS's camera_calibration replaces the calibration of a camera."""

from collections.abc import Callable, Mapping
from typing import Any

from sensor_msgs.msg import CameraInfo
from sensor_msgs.srv import SetCameraInfo

from ..configuration.calibration import parse_calibration, save_calibration
from ..configuration.config import check_size
from ..configuration.config_file import ConfigFile
from ..errors import CalibrationError
from ..table.reader import load_table
from ..table.stream_table import Stream
from .parameters import ParameterNode


def add_calibration_services(node: ParameterNode, prefix: str, file: ConfigFile) -> None:
    """Adds the service set_camera_info next to each camera_info.

    A new calibration is used from the next message on. It is written to the file that the camera's
    `calibration` names; if that fails, nothing changes. Without such a file, it is lost when the
    node ends.
    """
    for stream in load_table().streams.values():
        for topic in stream.topics:
            if topic.role == "camera_info":
                camera, _, _ = topic.full_name(prefix).rpartition("/")
                name = f"{camera}/set_camera_info"
                node.create_service(SetCameraInfo, name, _respond(node, stream, file))


def _respond(node: ParameterNode, stream: Stream, file: ConfigFile) -> Callable[[Any, Any], Any]:
    def respond(
        request: SetCameraInfo.Request, response: SetCameraInfo.Response
    ) -> SetCameraInfo.Response:
        try:
            response.status_message = _calibrate(node, stream, file, request.camera_info)
            response.success = True
        except CalibrationError as error:
            response.success, response.status_message = False, str(error)
        return response

    return respond


def _calibrate(node: ParameterNode, stream: Stream, file: ConfigFile, info: CameraInfo) -> str:
    """Stores the calibration and returns a message for the answer; raises CalibrationError."""
    config, section = node.config, stream.section
    if stream.id not in config.requests:
        raise CalibrationError(f"{stream.id} is not enabled, so what would be set is unknown")
    calibration = parse_calibration(_document(info))
    check_size(calibration, section, config.values)
    path = config.calibration_file(section)
    if path is not None:
        save_calibration(path, stream.id, calibration)
    node.calibrate(section, calibration)
    if path is not None:
        return f"applied, and written to {path}"
    return (
        "applied until the receiver ends; to keep it, save it to a file in camera_calibration"
        f" too, and name that in {file.path} as {section}.calibration"
    )


def _document(info: CameraInfo) -> Mapping[str, Any]:
    """Returns the calibration in the layout of a file of camera_calibration."""
    return {
        "image_width": info.width,
        "image_height": info.height,
        "distortion_model": info.distortion_model,
        "distortion_coefficients": {"rows": 1, "cols": len(info.d), "data": info.d},
        "camera_matrix": {"rows": 3, "cols": 3, "data": info.k},
        "rectification_matrix": {"rows": 3, "cols": 3, "data": info.r},
        "projection_matrix": {"rows": 3, "cols": 4, "data": info.p},
    }

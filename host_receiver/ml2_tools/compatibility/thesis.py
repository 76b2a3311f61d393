"""Converts messages to those of the thesis's scripts; see docs/from_the_thesis.md."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from ml2_receiver.json_text import json_text
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import StreamTable
from ml2_receiver.topics.config_topic import ConfigText
from ml2_receiver.wire.json_body import Scalar

# The camera sections of the thesis's configuration, and the keys of each.
_CAMERAS = (
    "picture_center",
    "depth_center",
    *(f"world_{place}" for place in ("center", "right", "left")),
    *(f"eye_temple_{side}" for side in ("right", "left")),
    *(f"eye_nasal_{side}" for side in ("right", "left")),
)
_KEYS = ("stream", "resolution_width", "resolution_height", "update_rate", "format")
_OTHERS = "other_sensors"
# The index of the first tangential coefficient, by model.
_TANGENTIAL_FROM = {"fisheye_tangential": 4}


def metadata_text(metadata: str) -> str:
    """Converts the JSON of a metadata topic to lines of `Name: value`, without rounding.

    Raises:
        ValueError: the text is not the JSON of metadata.
    """
    try:
        document = json.loads(metadata)
        if not isinstance(document, dict):
            raise TypeError("expected an object")
        return "".join(f"{line}\n" for line in _lines(document))
    except (AttributeError, KeyError, OverflowError, TypeError, RecursionError) as error:
        raise ValueError(f"invalid metadata: {type(error).__name__}: {error}") from error


def _lines(metadata: Mapping[str, Any]) -> Iterator[str]:
    if "analog_gain" in metadata:
        yield f"AnalogGain: {metadata['analog_gain']}"
    if "digital_gain" in metadata:
        yield f"DigitalGain: {metadata['digital_gain']}"
    if "exposure_ns" in metadata:
        yield f"ExposureTime: {metadata['exposure_ns'] / 1e6}"
    if "illumination" in metadata:
        yield f"IlluminationType: {metadata['illumination'].capitalize()}"
    if "intrinsics" in metadata:
        lens = metadata["intrinsics"]
        coefficients, model = lens["distortion"], lens["distortion_model"]
        yield f"Focal Length: {_pair(lens['focal_length'])}"
        yield f"Principal Point: {_pair(lens['principal_point'])}"
        if model in _TANGENTIAL_FROM:
            first = _TANGENTIAL_FROM[model]
            yield f"Radial Distortion: {_list(coefficients[:first])}"
            yield f"Tangential Distortion: {_list(coefficients[first:])}"
        else:
            yield f"Distortion: {_list(coefficients)}"


def _pair(values: Any) -> str:
    x, y = values
    return f"({x}, {y})"


def _list(values: Any) -> str:
    return f"[{','.join(str(float(it)) for it in values)}]"


def rotate_imu(message: Any, frame: str) -> Any:
    """Changes a sensor_msgs/Imu to the thesis's axes and frame, and returns it.

    Rotates both vectors by -90 degrees about z and sets the covariances to zeros.
    """
    message.header.frame_id = frame
    for vector in (message.angular_velocity, message.linear_acceleration):
        vector.x, vector.y = vector.y, -vector.x
    for covariance in (
        message.angular_velocity_covariance,
        message.linear_acceleration_covariance,
    ):
        covariance[:] = 0.0
    return message


def configuration_text(applied: str, prefix: str) -> str:
    """Converts a message of the receiver's topic `config` to the thesis's configuration as JSON.

    Raises:
        ProtocolError: the text is not that of a `config` topic.
    """
    table = load_table()
    streams = ConfigText.parse(applied.encode()).streams
    running = {
        table.streams[id].section: entry.values or {}
        for id, entry in streams.items()
        if id in table.streams and entry.result != "refused"
    }
    sections: dict[str, Mapping[str, Scalar]] = {"general": {"topic_name": prefix}}
    for section in _CAMERAS:
        sections[section] = _camera(table, section, running)
    sections[_OTHERS] = {"enabled": _OTHERS in running}
    return json_text(sections)


def _camera(
    table: StreamTable, section: str, running: Mapping[str, Mapping[str, Scalar]]
) -> Mapping[str, Scalar]:
    defaults = {key: table.sections[section].keys[key].default for key in _KEYS}
    # The first one is the thesis's, which had no other for this camera.
    defaults["format"] = table.sections[section].modes[0].formats[0]
    values = {key: value for key, value in running.get(section, {}).items() if key in _KEYS}
    return {"enabled": section in running, **defaults, **values}

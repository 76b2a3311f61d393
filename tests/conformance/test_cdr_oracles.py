"""Readers and a writer that are not ours agree with every vector: its bytes are its fields."""

import importlib
import struct
from typing import Any

import pytest
from rclpy.serialization import deserialize_message

from case_files import load
from message_definitions import typestore

CASES = load("cdr")
ROSBAGS = typestore()
PACKET = "ffmpeg_image_transport_msgs/msg/FFMPEGPacket"


@pytest.mark.parametrize("case", CASES)
def test_rosbags_reads_the_fields_and_writes_the_bytes(case: str) -> None:
    _, vector, data = CASES[case]
    message = ROSBAGS.deserialize_cdr(data, vector["type"])
    assert_fields(vector["message"], message, case)
    assert bytes(ROSBAGS.serialize_cdr(message, vector["type"])) == data


@pytest.mark.parametrize("case", CASES)
def test_rclpy_reads_the_fields(case: str) -> None:
    _, vector, data = CASES[case]
    package, _, name = vector["type"].split("/")
    message_class = getattr(importlib.import_module(f"{package}.msg"), name)
    message = deserialize_message(data, message_class)
    assert_fields(vector["message"], message, case)


@pytest.mark.parametrize("case", CASES)
def test_the_sizes_are_those_of_the_bytes(case: str) -> None:
    _, vector, data = CASES[case]
    assert vector["size"] == len(data)
    if vector["type"] in ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", PACKET):
        prefix, pixels = data[: vector["prefix_size"]], data[vector["prefix_size"] :]
        assert struct.unpack("<I", prefix[-4:]) == (len(pixels),)
        assert pixels == pattern(vector["message"]["data"])
    else:
        assert "prefix_size" not in vector


def assert_fields(expected: Any, found: Any, path: str) -> None:
    match expected:
        case {"pattern": _}:
            assert bytes(found) == pattern(expected), path
        case dict():
            assert set(expected) == field_names(found), path
            for name, value in expected.items():
                assert_fields(value, getattr(found, name), f"{path}.{name}")
        case list():
            assert len(expected) == len(found), path
            for index, (value, element) in enumerate(zip(expected, found, strict=True)):
                assert_fields(value, element, f"{path}[{index}]")
        case "NaN" | "Infinity" | "-Infinity":
            assert str(float(found)) == str(float(expected)), path
        case float():
            # As bytes, because 0.0 == -0.0
            assert struct.pack("<d", found) == struct.pack("<d", expected), path
        case int() if isinstance(found, bytes):  # an octet in rclpy
            assert found == bytes([expected]), path
        case _:
            assert found == expected, path


def field_names(message: Any) -> set[str]:
    if hasattr(message, "__msgtype__"):
        return {name for name, _ in ROSBAGS.get_msgdef(message.__msgtype__).fields}
    return set(message.get_fields_and_field_types())


def pattern(rule: dict[str, Any]) -> bytes:
    assert rule["pattern"] == "index mod 251"
    return bytes(index % 251 for index in range(rule["length"]))

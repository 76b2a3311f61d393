"""A recording of test signals and of a custom topic, which the headset's app publishes.

Test signals contain the frame number of their capture, which must match the metadata's.
"""

from __future__ import annotations

import itertools
import json
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from capture_stamps import stamp_ns
from counters import assert_counters_agree
from processes import PREFIX, Received, receive

CONFIG = """
/ml2_receiver:
  ros__parameters:
    world_left: {enabled: true}
    depth_center: {enabled: true, confidence: true, flags: true}
    eye_nasal_left: {enabled: true}
    picture_center: {enabled: true, resolution_width: 640, resolution_height: 480}
    custom: {enabled: true}
"""


@pytest.fixture(scope="module")
def received(tmp_path_factory: pytest.TempPathFactory) -> Received:
    folder = tmp_path_factory.mktemp("test_signal")
    (folder / "config.yaml").write_text(CONFIG)
    return receive(folder / "config.yaml", ["--source", "test-signal", "--duration", "2"], folder)


def frame_numbers(received: Received, camera: str) -> dict[int, int]:
    """Returns the frame numbers in the metadata by stamp in ns."""
    metadata = received.messages(f"{camera}/metadata")
    assert metadata
    return {stamp_ns(it): json.loads(it.data)["frame_number"] for it in metadata}


@pytest.mark.parametrize(
    ("topic", "dtype"),
    [
        ("world_left/image_raw", np.uint8),
        ("eye_nasal_left/image_raw", np.uint8),
        ("depth/image_raw", np.float32),
        ("depth/confidence", np.float32),
        ("depth/flags", np.int32),
    ],
)
def test_raw_images_carry_the_number_of_their_capture(
    received: Received, topic: str, dtype: type
) -> None:
    numbers = frame_numbers(received, topic.split("/")[0])
    for image in received.messages(topic):
        pixels: NDArray[Any] = np.frombuffer(bytes(image.data), dtype)
        number = int("".join("1" if pixel else "0" for pixel in pixels[:32] > 0), 2)
        assert number == numbers.get(stamp_ns(image), number)


def test_jpegs_carry_the_number_of_their_capture(received: Received) -> None:
    numbers = frame_numbers(received, "color")
    for image in received.messages("color/image_raw/compressed"):
        data = bytes(image.data)
        at = data.index(b"\xff\xfe") + 4
        assert data[at : at + 6] == b"frame="
        number = int(data[at + 6 : at + 16])
        assert number == numbers.get(stamp_ns(image), number)


def test_messages_of_a_custom_topic_arrive_like_those_of_a_sensor(received: Received) -> None:
    topic = f"{PREFIX}/custom/app_uptime"
    assert received.topics[topic][0] == "std_msgs/msg/Float64"
    uptimes_s = [message.data for message in received.messages("custom/app_uptime")]
    assert len(uptimes_s) > 10
    steps_s = [b - a for a, b in itertools.pairwise(uptimes_s)]
    assert min(steps_s) >= 0.1
    assert received.qos[topic] == {("RELIABLE", "VOLATILE")}
    counters = received.counters(topic)
    assert counters["received"] == str(len(uptimes_s))
    assert_counters_agree(received)
    assert received.snapshot["streams"]["custom"]["result"] == "applied"

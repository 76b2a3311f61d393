"""Recorded images that the headset compressed, as readers that are not ours see them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

import bag_scene
from bag_readers import READERS, Seen, decoded_with_mcap, decoded_with_rosbags, digest
from compressed_images import FORMAT, compressed_depth
from ml2_tools.images.pixels import pixels_of

COUNT = 5
JPEG, DEPTH = map(bag_scene.absolute, bag_scene.COMPRESSED)
DECODING = [decoded_with_rosbags, decoded_with_mcap]

type Decode = Callable[[Path], list[tuple[str, Any]]]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags") / "walk"
    bag_scene.record(folder, COUNT, request=bag_scene.COMPRESSED_REQUEST)
    return folder


@pytest.mark.parametrize("read", READERS)
def test_compressed_images_are_recorded_as_they_were_sent(
    recording: Path, read: Callable[[Path], list[Seen]]
) -> None:
    seen = read(recording)
    for name, (type, make) in bag_scene.COMPRESSED.items():
        topic = bag_scene.absolute(name)
        assert [it for it in seen if it.topic == topic] == [
            Seen(topic, type, (number, 5), digest(make(number))) for number in range(COUNT)
        ]


@pytest.mark.parametrize("decode", DECODING)
def test_opencv_reads_the_jpeg_of_a_decoded_message(recording: Path, decode: Decode) -> None:
    images = [message for topic, message in decode(recording) if topic == JPEG]
    assert len(images) == COUNT
    for number, message in enumerate(images):
        assert message.format == "mono8; jpeg compressed mono8"
        found = cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_UNCHANGED)
        assert found is not None
        assert cv2.PSNR(found, bag_scene.pixels(number)) > 30, "dB"


@pytest.mark.parametrize("decode", DECODING)
def test_a_decoded_message_has_the_millimetres_of_depth(recording: Path, decode: Decode) -> None:
    images = [message for topic, message in decode(recording) if topic == DEPTH]
    assert len(images) == COUNT
    for number, message in enumerate(images):
        mm = bag_scene.millimetres(number)
        assert (message.format, bytes(message.data)) == (FORMAT, compressed_depth(mm))
        found = np.nan_to_num(pixels_of(message)) * 1000
        np.testing.assert_allclose(found, mm, atol=0.01)

"""Reading a camera's images and calibration from a bag that rosbags wrote."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from bags import write_bag
from ml2_receiver.topics.plain_messages import encode_string
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.errors import EvaluationError
from ml2_tools.evaluation.sequence import read_sequence
from wall_walk import (
    CAMERA,
    COMPRESSED,
    IMAGE,
    PREFIX,
    TYPES,
    images,
    jpeg,
    recording,
    trajectory,
)

COUNT = 6


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recording(tmp_path_factory.mktemp("walk") / "bag", COUNT, images_dropped=(2,))


def test_images_come_with_their_stamps_and_pixels(bag: Path) -> None:
    sequence = read_sequence(bag, CAMERA)
    sent = [it for number, it in enumerate(images(COUNT)) if number != 2]
    found = list(sequence.images())
    assert [at for at, _ in found] == [at for at, _ in sent] == sequence.stamps_ns
    for (_, ours), (_, theirs) in zip(found, sent, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_images_that_the_headset_compressed_are_read_as_opencv_decodes_them(
    tmp_path: Path,
) -> None:
    bag = recording(tmp_path / "bag", COUNT, images_dropped=(2,), is_compressed=True)
    sequence = read_sequence(bag, CAMERA)
    assert (sequence.topic, sequence.type) == (COMPRESSED, "sensor_msgs/msg/CompressedImage")
    assert (sequence.images_sent, len(sequence.stamps_ns)) == (COUNT, COUNT - 1)
    sent = [it for number, it in enumerate(images(COUNT)) if number != 2]
    for (found_ns, found), (sent_ns, pixels) in zip(sequence.images(), sent, strict=True):
        assert found_ns == sent_ns
        np.testing.assert_array_equal(found, cv2.imdecode(jpeg(pixels), cv2.IMREAD_GRAYSCALE))


def test_an_image_that_never_arrived_counts_as_sent(bag: Path) -> None:
    sequence = read_sequence(bag, CAMERA)
    assert (sequence.images_sent, len(sequence.stamps_ns)) == (COUNT, COUNT - 1)


def test_poses_are_those_of_the_optical_frame(bag: Path) -> None:
    found, sent = read_sequence(bag, CAMERA).reference, trajectory(COUNT)
    assert [at for at, _ in found] == [at for at, _ in sent]
    np.testing.assert_allclose([it for _, it in found], [it for _, it in sent], atol=1e-9)


def test_another_camera_is_not_in_it(bag: Path) -> None:
    with pytest.raises(EvaluationError, match="has no images with camera_info of world_right"):
        read_sequence(bag, "world_right")


@pytest.mark.parametrize("size", [60, 10, 0])
def test_a_payload_that_is_no_image_is_told(tmp_path: Path, bag: Path, size: int) -> None:
    cut = [(at, ns, it[:size] if at == IMAGE else it) for at, ns, it in messages_of(bag)]
    write_bag(tmp_path / "bag", TYPES, cut)
    with pytest.raises(EvaluationError, match=IMAGE):
        list(read_sequence(tmp_path / "bag", CAMERA).images())


def test_metadata_that_are_no_object_count_no_image(tmp_path: Path, bag: Path) -> None:
    found = messages_of(bag)
    last_ns = found[-1][1]
    write_bag(
        tmp_path / "bag",
        TYPES,
        [*found, (f"{PREFIX}/{CAMERA}/metadata", last_ns, encode_string("[1]"))],
    )
    assert read_sequence(tmp_path / "bag", CAMERA).images_sent == COUNT


def messages_of(bag: Path) -> list[tuple[str, int, bytes]]:
    config = (f"{PREFIX}/config", 0, encode_string('{"headset":"h","session":"s","streams":{}}'))
    rest = [(it.topic, it.time_ns, it.payload) for it in BagReader(bag).messages()]
    return [config, *(it for it in rest if it[0] != config[0])]

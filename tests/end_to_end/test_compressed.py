"""Images that the headset compresses are, to the readers of image_transport, those of raw topics.

The simulated head stands still and nothing has noise, so each image of the world is the same.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from capture_stamps import stamp_ns
from configurations import only
from ml2_tools.images.pixels import pixels_of
from other_programs import collect, streaming
from processes import ROOT, Received
from test_reconfiguration import service_client

CONFIG = only(
    """
    world_left: {enabled: true},
    eye_nasal_left: {enabled: true},
    depth_center: {enabled: true, confidence: true},
    general: {link: fixed},
    """
)
QUALITY = {"world_left": 90, "eye_nasal_left": 60}
COMPRESSED = {
    "world_left.format": "jpeg",
    "world_left.quality": QUALITY["world_left"],
    "eye_nasal_left.format": "jpeg",
    "eye_nasal_left.quality": QUALITY["eye_nasal_left"],
    "depth_center.format": "depth16",
}
SIMULATION = {
    "trajectory": str(ROOT / "native" / "tests" / "still_head.tum"),
    "noise": "0",
    "image_noise": "0",
    "depth_noise_m": "0",
}
CAMERAS = ("world_left", "eye_nasal_left", "depth")
COUNT = 10


def compressed_topic(camera: str) -> str:
    suffix = "compressedDepth" if camera == "depth" else "compressed"
    return f"{camera}/image_raw/{suffix}"


IMAGES = {f"{it}/image_raw": "sensor_msgs/msg/Image" for it in CAMERAS}
COMPRESSED_IMAGES = {compressed_topic(it): "sensor_msgs/msg/CompressedImage" for it in CAMERAS}
METADATA = {f"{it}/metadata": "std_msgs/msg/String" for it in CAMERAS}
CONFIDENCE = {"depth/confidence": "sensor_msgs/msg/Image"}


@dataclass(frozen=True)
class Run:
    """The messages with raw formats, and those with compressed ones."""

    raw: Received
    compressed: Received


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Changes all formats of a running headset."""
    folder = tmp_path_factory.mktemp("compressed")
    (folder / "config.yaml").write_text(CONFIG)
    with (
        streaming(folder / "config.yaml", folder, **SIMULATION) as domain,
        service_client(domain, folder) as ask,
    ):
        raw = collect(IMAGES | METADATA, COUNT, domain, folder)
        assert ask("set", COMPRESSED) == [[True, ""]] * len(COMPRESSED)
        topics = COMPRESSED_IMAGES | METADATA | CONFIDENCE
        return Run(raw, collect(topics, COUNT, domain, folder))


@pytest.mark.parametrize("camera", CAMERAS)
def test_the_format_is_that_of_image_transport(run: Run, camera: str) -> None:
    expected = "16UC1; compressedDepth rvl" if camera == "depth" else "mono8; jpeg compressed mono8"
    assert {it.format for it in run.compressed.messages(compressed_topic(camera))} == {expected}


def test_opencv_reads_what_was_raw(run: Run) -> None:
    expected = pixels_of(run.raw.messages("world_left/image_raw")[-1]).astype(np.float64)
    for message in run.compressed.messages(compressed_topic("world_left")):
        error = float(np.mean((_grey(message) - expected) ** 2))
        assert 10 * np.log10(255**2 / error) > 38, "PSNR in dB"


@pytest.mark.parametrize("camera", ["world_left", "eye_nasal_left"])
def test_a_jpeg_has_one_component(run: Run, camera: str) -> None:
    for message in run.compressed.messages(compressed_topic(camera)):
        assert _components(bytes(message.data)) == 1
        pixels = _grey(message)
        assert pixels.shape == pixels_of(run.raw.messages(f"{camera}/image_raw")[0]).shape
        assert pixels.std() > 5, "it shows something"


def _grey(message: Any) -> NDArray[Any]:
    """Decodes a JPEG; a grey one has two dimensions."""
    data = np.frombuffer(message.data, np.uint8)
    pixels: NDArray[Any] | None = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    assert pixels is not None
    assert pixels.ndim == 2
    return pixels


def _components(jpeg: bytes) -> int:
    """Returns the number of components in the header of a baseline frame (ITU T.81, B.2.2)."""
    at = jpeg.index(b"\xff\xc0")
    return jpeg[at + 9]


def test_depth_is_within_half_a_millimetre(run: Run) -> None:
    expected = pixels_of(run.raw.messages("depth/image_raw")[-1])
    for message in run.compressed.messages(compressed_topic("depth")):
        header = np.frombuffer(message.data[:12], "<u4")
        assert header.tolist() == [0, 0, 0]
        metres = pixels_of(message)
        assert (np.isnan(metres) == np.isnan(expected)).all()
        assert np.nanmax(np.abs(metres - expected)) < 0.0005 + 1e-6
        assert np.isfinite(metres).mean() > 0.3


def test_depth_keeps_its_confidence(run: Run) -> None:
    stamps = {stamp_ns(it) for it in run.compressed.messages("depth/confidence")}
    images = [stamp_ns(it) for it in run.compressed.messages(compressed_topic("depth"))]
    assert len(stamps.intersection(images)) > COUNT / 2
    for message in run.compressed.messages("depth/confidence"):
        assert message.step == 4 * message.width
        assert pixels_of(message).max() > 0


@pytest.mark.parametrize("camera", CAMERAS)
def test_metadata_has_codec_quality_and_size(run: Run, camera: str) -> None:
    for message in run.raw.messages(f"{camera}/metadata"):
        assert json.loads(message.data).keys().isdisjoint({"codec", "quality", "encoded_bytes"})
    sizes = {stamp_ns(it): len(it.data) for it in run.compressed.messages(compressed_topic(camera))}
    described = 0
    for message in run.compressed.messages(f"{camera}/metadata"):
        told, stamp = json.loads(message.data), stamp_ns(message)
        if stamp in sizes:
            described += 1
            assert told["codec"] == ("rvl" if camera == "depth" else "jpeg")
            assert told.get("quality") == QUALITY.get(camera)
            assert told["encoded_bytes"] == sizes[stamp]
    assert described > COUNT / 2

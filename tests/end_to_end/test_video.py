"""Video of a world camera is H.264, which ffmpeg decodes to what was raw, with the same stamps.

The simulated head stands still and nothing has noise, so each image of the world is the same.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import av
import numpy as np
import pytest
from numpy.typing import NDArray

from capture_stamps import stamp_ns
from ml2_tools.images.pixels import pixels_of
from other_programs import collect, streaming
from processes import ROOT, Received
from test_reconfiguration import service_client

CONFIG = """
/ml2_receiver:
  ros__parameters:
    world_left: {enabled: true}
    general: {link: fixed}
"""
SIMULATION = {
    "trajectory": str(ROOT / "native" / "tests" / "still_head.tum"),
    "image_noise": "0",
}
COUNT = 75
RAW, VIDEO = "world_left/image_raw", "world_left/image_raw/ffmpeg"
CAMERA_INFO, METADATA = "world_left/camera_info", "world_left/metadata"
TYPES = {
    VIDEO: "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
    CAMERA_INFO: "sensor_msgs/msg/CameraInfo",
    METADATA: "std_msgs/msg/String",
}


@dataclass(frozen=True)
class Run:
    """The messages with the raw format, and those of the video."""

    raw: Received
    video: Received


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("video")
    (folder / "config.yaml").write_text(CONFIG)
    with (
        streaming(folder / "config.yaml", folder, **SIMULATION) as domain,
        service_client(domain, folder) as ask,
    ):
        raw = collect({RAW: "sensor_msgs/msg/Image"}, 2, domain, folder)
        assert ask("set", {"world_left.format": "h264"}) == [[True, ""]]
        return Run(raw, collect(TYPES, COUNT, domain, folder))


def test_packets_are_those_of_ffmpeg_image_transport(run: Run) -> None:
    packets = run.video.messages(VIDEO)
    assert {it.encoding for it in packets} == {"h264;yuv420p;mono8;mono8"}
    assert {(it.width, it.height, it.is_bigendian) for it in packets} == {(1016, 1016, False)}
    assert {it.flags for it in packets} == {0, 1}
    times = [it.pts for it in packets]
    assert sorted(set(times)) == times


def test_a_key_frame_comes_each_second(run: Run) -> None:
    keys = [stamp_ns(it) for it in run.video.messages(VIDEO) if it.flags]
    assert len(keys) > 1
    assert np.diff(keys) / 1e9 == pytest.approx(1, abs=0.1)


def test_ffmpeg_decodes_what_was_raw(run: Run) -> None:
    expected = pixels_of(run.raw.messages(RAW)[0]).astype(np.float64)
    decoded = decode(run.video.messages(VIDEO))
    assert len(decoded) > COUNT / 2
    for pixels in decoded:
        error = float(np.mean((pixels - expected) ** 2))
        assert 10 * np.log10(255**2 / error) > 36, "PSNR in dB"


def decode(packets: list[Any]) -> list[NDArray[Any]]:
    """Returns the luma of every packet from the first key frame on."""
    codec = av.CodecContext.create("h264", "r")
    found = []
    first = next(index for index, it in enumerate(packets) if it.flags)
    for message in packets[first:]:
        (frame,) = codec.decode(av.Packet(bytes(message.data)))
        found.append(frame.to_ndarray()[: frame.height])
    return found


def test_camera_info_and_metadata_have_its_stamps(run: Run) -> None:
    sizes = {stamp_ns(it): len(it.data) for it in run.video.messages(VIDEO)}
    infos = {stamp_ns(it) for it in run.video.messages(CAMERA_INFO)}
    assert len(infos & sizes.keys()) > COUNT / 2
    described = 0
    for message in run.video.messages(METADATA):
        told = json.loads(message.data)
        stamp = told["stamp"]["sec"] * 10**9 + told["stamp"]["nanosec"]
        if stamp in sizes:
            described += 1
            assert (told["codec"], told["encoded_bytes"]) == ("h264", sizes[stamp])
            assert "quality" not in told
    assert described > COUNT / 2

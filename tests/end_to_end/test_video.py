"""Video is H.264, which ffmpeg decodes to what the images were before, with the stamps of captures.

The simulated head stands still and nothing has noise, so each image of a camera is the same.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader

from bags import message_counts
from capture_stamps import nanos, stamp_ns
from configurations import only
from ml2_tools.images.pixels import pixels_of
from other_programs import collect, streaming
from processes import (
    PAUSE_S,
    RECEIVER,
    ROOT,
    Received,
    draw_images,
    full_name,
    headset_command,
    isolated_environment,
    listening_address,
    process,
)
from shaped_link import link, why_not
from test_reconfiguration import service_client
from waiting import await_true

CONFIG = only(
    """
    world_left: {enabled: true},
    picture_center: {enabled: true, resolution_width: 1280, resolution_height: 720},
    general: {link: fixed},
    """
)
THIN = only("world_left: {enabled: true, format: h264, bit_rate_mbit: 8}, general: {link: fixed}")
SIMULATION = {
    "trajectory": str(ROOT / "native" / "tests" / "still_head.tum"),
    "noise": "0",
    "image_noise": "0",
}
COUNT = 75
FFMPEG = full_name("world_left/image_raw/ffmpeg")
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
BEFORE = {
    "world_left/image_raw": "sensor_msgs/msg/Image",
    "color/image_raw/compressed": "sensor_msgs/msg/CompressedImage",
}
SIZES = {"world_left": (1016, 1016), "color": (1280, 720)}
ENCODINGS = {"world_left": "h264;yuv420p;mono8;mono8", "color": "h264;yuv420p;bgr8;bgr8"}
TYPES = {
    "image_raw/ffmpeg": "ffmpeg_image_transport_msgs/msg/FFMPEGPacket",
    "camera_info": CAMERA_INFO,
    "metadata": "std_msgs/msg/String",
}
# The NAL unit of type 7 in an Annex B stream, with which each key frame begins (H.264, 7.4.1).
SEQUENCE_PARAMETERS = re.compile(rb"\x00\x00\x01[\x27\x47\x67]")
each_camera = pytest.mark.parametrize("camera", SIZES)


@dataclass(frozen=True)
class Run:
    """The messages with the formats before, and those of the video."""

    before: Received
    video: Received

    def packets(self, camera: str) -> list[Any]:
        return self.video.messages(f"{camera}/image_raw/ffmpeg")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Changes the format of running cameras."""
    folder = tmp_path_factory.mktemp("video")
    (folder / "config.yaml").write_text(CONFIG)
    topics = {f"{camera}/{name}": type for camera in SIZES for name, type in TYPES.items()}
    with (
        streaming(folder / "config.yaml", folder, **SIMULATION) as domain,
        service_client(domain, folder) as ask,
    ):
        before = collect(BEFORE, 2, domain, folder)
        video = {"world_left.format": "h264", "picture_center.format": "h264"}
        assert ask("set", video) == [[True, ""]] * 2
        return Run(before, collect(topics, COUNT, domain, folder))


@each_camera
def test_packets_are_those_of_ffmpeg_image_transport(run: Run, camera: str) -> None:
    packets = run.packets(camera)
    assert {it.encoding for it in packets} == {ENCODINGS[camera]}
    assert {(it.width, it.height) for it in packets} == {SIZES[camera]}
    assert {it.is_bigendian for it in packets} == {False}
    assert {it.flags for it in packets} == {0, 1}
    times = [it.pts for it in packets]
    assert sorted(set(times)) == times


@each_camera
def test_a_key_frame_comes_each_second(run: Run, camera: str) -> None:
    """A busy machine may lose the capture that was due; the next one is a key frame then."""
    packets = run.packets(camera)
    stamps_ns = [stamp_ns(it) for it in packets]
    keys_ns = [at_ns for at_ns, it in zip(stamps_ns, packets, strict=True) if it.flags]
    assert len(keys_ns) > 1
    for key_ns, next_ns in pairwise(keys_ns):
        due_ns = key_ns + 10**9 - 10**6  # stamps follow the host's clock
        assert next_ns == min(it for it in stamps_ns if it >= due_ns)


@pytest.mark.parametrize(("camera", "least_db"), [("world_left", 36), ("color", 32)])
def test_ffmpeg_decodes_what_the_images_were(run: Run, camera: str, least_db: float) -> None:
    (before,) = (it for it in BEFORE if it.startswith(camera))
    expected = pixels_of(run.before.messages(before)[0]).astype(np.float64)
    decoded = decode(run.packets(camera), "gray" if expected.ndim == 2 else "bgr24")
    assert len(decoded) > COUNT / 2
    for pixels in decoded:
        error = float(np.mean((pixels - expected) ** 2))
        assert 10 * np.log10(255**2 / error) > least_db, "PSNR in dB"


def decode(messages: list[Any], format: str) -> list[NDArray[Any]]:
    """Returns the image of every message from the first key frame on; ffmpeg misses none before."""
    codec = av.CodecContext.create("h264", "r")
    codec.thread_count = 1
    found = []
    units = [bytes(it.data) for it in messages]
    first = next(index for index, it in enumerate(units) if SEQUENCE_PARAMETERS.search(it))
    av.logging.set_level(av.logging.ERROR)
    with av.logging.Capture() as complaints:
        for unit in units[first:]:
            (frame,) = codec.decode(av.Packet(unit))
            found.append(frame.to_ndarray(format=format))
    assert complaints == []
    return found


def test_what_a_thin_link_leaves_of_a_video_can_be_decoded(tmp_path: Path) -> None:
    """A link of 5 Mbit/s takes half of the images."""
    if reason := why_not():
        pytest.skip(reason)
    (tmp_path / "config.yaml").write_text(THIN)
    noisy = ("--simulate", "image_noise=4")
    draw_images(tmp_path / "config.yaml", noisy)
    record: list[str | Path] = [RECEIVER, "record", tmp_path / "walk", "--no-ros", "--insecure"]
    record += ["--config", tmp_path / "config.yaml"]
    environment = isolated_environment()
    with link("cubic", 5) as made:
        record = [*made.receiver.prefix, *record, "--listen", f"{made.receiver.address}:0"]
        with process(record, environment, tmp_path / "receiver.log") as receiver:
            headset = headset_command(listening_address(receiver), *noisy)
            command = [*made.headset.prefix, *headset]
            with process(command, environment, tmp_path / "headset.log", is_read=False):
                walk = tmp_path / "walk"
                await_true(lambda: message_counts(walk).get(FFMPEG, 0) > COUNT, PAUSE_S)
    with AnyReader([tmp_path / "walk"]) as bag:
        topics = [it for it in bag.connections if it.topic.endswith("/ffmpeg")]
        packets: list[Any] = [bag.deserialize(it[2], it[0].msgtype) for it in bag.messages(topics)]
    intervals_s = np.diff([it.pts for it in packets]) / 1e6
    assert intervals_s.max() > 1.5 / 30, "images were left out"
    keys = sum(it.flags for it in packets)
    assert len(decode(packets, "gray")) > 2 * keys > 2


def test_foxglove_gets_the_same_video_in_its_own_type(tmp_path: Path) -> None:
    config, topic = tmp_path / "config.yaml", "world_left/image_raw/foxglove"
    config.write_text(THIN.replace("h264", "h264_foxglove"))
    with streaming(config, tmp_path, **SIMULATION) as domain:
        types = {topic: "foxglove_msgs/msg/CompressedVideo", "world_left/camera_info": CAMERA_INFO}
        received = collect(types, 40, domain, tmp_path)
    images = received.messages(topic)
    assert {(it.format, it.frame_id) for it in images} == {("h264", "world_left_optical_frame")}
    infos = {stamp_ns(it) for it in received.messages("world_left/camera_info")}
    assert len(infos.intersection(nanos(it.timestamp) for it in images)) > 20
    assert {it.shape for it in decode(images, "gray")} == {(1016, 1016)}


@each_camera
def test_camera_info_and_metadata_have_its_stamps(run: Run, camera: str) -> None:
    sizes = {stamp_ns(it): len(it.data) for it in run.packets(camera)}
    infos = {stamp_ns(it) for it in run.video.messages(f"{camera}/camera_info")}
    assert len(infos & sizes.keys()) > COUNT / 2
    described = 0
    for message in run.video.messages(f"{camera}/metadata"):
        told, stamp = json.loads(message.data), stamp_ns(message)
        if stamp in sizes:
            described += 1
            assert (told["codec"], told["encoded_bytes"]) == ("h264", sizes[stamp])
            assert "quality" not in told
    assert described > COUNT / 2

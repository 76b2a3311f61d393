"""Headset and receiver paired by their commands, and what who listens between them sees."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from ml2_receiver.configuration.table import load_table
from pairing import pair
from processes import (
    HEADSET,
    RECEIVER,
    isolated_environment,
    line_with,
    lines,
    listening_address,
    process,
    result,
    subscribing,
)
from proxy import Proxy

CONFIG = """
/**:
  ros__parameters:
    world_center: {enabled: true}
    eye_nasal_left: {enabled: true}
"""
IMAGE = "world_center/image_raw"
EYE = "eye_nasal_left/image_raw"
CHUNK_PIXELS = 32


@pytest.fixture
def config(tmp_path: Path) -> Path:
    file = tmp_path / "config.yaml"
    file.write_text(CONFIG)
    return file


@pytest.fixture
def keys(tmp_path: Path) -> tuple[Path, Path]:
    """Of a receiver and a headset that are paired."""
    receiver, headset = tmp_path / "receiver", tmp_path / "headset"
    pair([RECEIVER, "pair", "--keys", receiver], [HEADSET, "--keys", headset])
    return receiver, headset


def run_command(config: Path, keys: Path, *options: str) -> list[str | Path]:
    listen = ["--listen", "127.0.0.1:0"]
    return [RECEIVER, "run", "--config", config, *listen, "--keys", keys, *options]


def headset_command(address: str, keys: Path, *options: str) -> list[str | Path]:
    return [HEADSET, "--receiver", address, "--keys", keys, *options]


def test_nothing_of_a_paired_session_can_be_read_between_the_two(
    config: Path, keys: tuple[Path, Path], tmp_path: Path
) -> None:
    environment = isolated_environment()
    run = run_command(config, keys[0], "--start-paused")
    with (
        process(run, environment, tmp_path / "receiver.log") as receiver,
        Proxy(listening_address(receiver), captures=True) as proxy,
        subscribing(environment, tmp_path) as subscriber,
    ):
        send = headset_command(proxy.address, keys[1], "--duration", "3")
        with process(send, environment, tmp_path / "headset.log"):
            for _ in lines(subscriber):
                pass
        received = result(subscriber, tmp_path)
    images = received.messages(IMAGE)
    assert images
    assert received.messages(EYE), "with TLS eye images are sent"
    captured = bytes(proxy.captured)
    assert len(captured) > sum(len(image.data) for image in images)
    for image in images[:10]:
        for row in np.frombuffer(image.data, np.uint8).reshape(image.height, -1)[::50]:
            assert row[:CHUNK_PIXELS].tobytes() not in captured
    words = {topic.name for stream in load_table().streams.values() for topic in stream.topics}
    for word in words | {"ticket", "session", "sensor_msgs"}:
        assert len(word) < 4 or word.encode() not in captured


def test_a_headset_that_is_not_paired_is_told_what_to_do(
    config: Path, keys: tuple[Path, Path], tmp_path: Path
) -> None:
    environment = isolated_environment()
    run = run_command(config, keys[0])
    unpair = [str(RECEIVER), "unpair", "--keys", str(keys[0])]
    paired = [str(RECEIVER), "devices", "--paired", "--json", "--keys", str(keys[0])]
    with process(run, environment, tmp_path / "receiver.log") as receiver:
        address = listening_address(receiver)
        shown = subprocess.run(paired, stdout=subprocess.PIPE, text=True, check=True).stdout
        (device,) = json.loads(shown)
        subprocess.run([*unpair, device["name"]], check=True)
        with process(
            headset_command(address, keys[1]), environment, tmp_path / "headset.log"
        ) as headset:
            line_with(headset, "not paired")
    assert "pairing: it is not paired" in (tmp_path / "receiver.log").read_text()

"""The configuration is changed while a simulated headset streams."""

from __future__ import annotations

import contextlib
import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from capture_stamps import stamp_ns
from configurations import only
from counters import await_more, await_snapshot, have_arrived
from ml2_receiver.topics.judgement import read_judgements
from processes import (
    PREFIX,
    ROOT,
    Received,
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
    result,
    subscribing,
)
from simulation import STILL

CONFIG = only(
    """
    picture_center: {enabled: true, resolution_width: 640, resolution_height: 480},
    depth_center: {enabled: true},
    other_sensors: {enabled: true},
    """
)
IMAGES = {"color": "color/image_raw/compressed", "depth": "depth/image_raw"}
COUNT = 20
UNDISTURBED = ("color/image_raw/compressed", "color/camera_info", "gyro_left/imu")


@contextlib.contextmanager
def service_client(environment: dict[str, str], folder: Path) -> Iterator[Callable[..., Any]]:
    """Runs a node that calls the receiver's services; see ros_client.py. Yields the call."""
    command = [sys.executable, str(ROOT / "host_receiver" / "test" / "ros_client.py")]
    with process(command, environment, folder / "client.log", subprocess.PIPE) as child:

        def ask(*call: Any) -> Any:
            assert child.stdin is not None
            child.stdin.write(json.dumps(call) + "\n")
            child.stdin.flush()
            return json.loads(lines(child).readline())

        yield ask


def run(folder: Path) -> Received:
    """Disables depth, enables it after more images of the other camera, and enables battery."""
    (folder / "config.yaml").write_text(CONFIG)
    environment = isolated_environment()
    with contextlib.ExitStack() as stack:
        start = stack.enter_context
        command = receive_command(folder / "config.yaml", "127.0.0.1:0", "--start-paused")
        receiver = start(process(command, environment, folder / "receiver.log"))
        address = listening_address(receiver)
        ask = start(service_client(environment, folder))
        subscriber = start(subscribing(environment, folder))
        command = headset_command(address, *STILL)
        headset = start(process(command, environment, folder / "headset.log"))
        await_snapshot(subscriber, have_arrived(dict.fromkeys(IMAGES.values(), 1)))
        for is_enabled, camera in ((False, "color"), (True, "depth")):
            assert ask("enable", "depth_center", is_enabled) == [True, ""]
            # A busy machine may have captured some before that come now
            await_more(subscriber, IMAGES[camera], 2 * COUNT)
        assert ask("set", {"battery.enabled": True}) == [[True, ""]]
        await_snapshot(subscriber, lambda it: "battery" in read_judgements(it["session"]))
        headset.terminate()
        return result(subscriber, folder)


def pauses(received: Received, camera: str, other: str) -> int:
    """Returns how often a camera delivered nothing while another one delivered COUNT images."""
    own, others = (
        np.array([stamp_ns(message) for message in received.messages(f"{it}/metadata")])
        for it in (camera, other)
    )
    return int((np.diff(np.searchsorted(np.sort(others), np.sort(own))) > COUNT).sum())


def test_only_the_changed_stream_restarts(tmp_path: Path) -> None:
    received = run(tmp_path)
    for topic in UNDISTURBED:
        counters = received.counters(f"{PREFIX}/{topic}")
        # Messages that a busy machine dropped were not lost by the reconfiguration.
        reasons = {key for key in counters if key.startswith("dropped.")} - {"dropped.link_down"}
        assert int(counters["gaps"]) == sum(int(counters[key]) for key in reasons), topic
    assert pauses(received, "color", "depth") == 0
    assert pauses(received, "depth", "color") > 0  # a busy machine adds some
    log = (tmp_path / "headset.log").read_text()
    assert re.findall(r"^  (\w+): ended$", log, re.MULTILINE) == ["depth"]
    assert f"{PREFIX}/battery" in received.graph

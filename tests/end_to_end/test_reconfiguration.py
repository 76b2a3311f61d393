"""The configuration is changed while a simulated headset streams."""

from __future__ import annotations

import contextlib
import itertools
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from capture_stamps import stamp_ns
from configurations import only
from processes import (
    PREFIX,
    ROOT,
    Received,
    draw_images,
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
IMAGES = ("color/image_raw/compressed", "depth/image_raw")
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


def has_images(snapshot: dict[str, Any]) -> bool:
    """Returns True if images arrived; opening cameras may take seconds before that."""
    return all(snapshot["topics"].get(f"{PREFIX}/{name}", {}).get("count", 0) for name in IMAGES)


def run(folder: Path) -> Received:
    """Disables depth after about 1 s, enables it after 3 s, and enables battery after 4 s."""
    (folder / "config.yaml").write_text(CONFIG)
    draw_images(folder / "config.yaml", STILL, folder)
    environment = isolated_environment()
    with contextlib.ExitStack() as stack:
        start = stack.enter_context
        command = receive_command(folder / "config.yaml", "127.0.0.1:0", "--start-paused")
        receiver = start(process(command, environment, folder / "receiver.log"))
        address = listening_address(receiver)
        ask = start(service_client(environment, folder))
        subscriber = start(subscribing(environment, folder))
        headset = headset_command(address, *STILL, "--duration", "6")
        start(process(headset, environment, folder / "headset.log"))
        seconds = (line for line in lines(subscriber) if has_images(json.loads(line)))
        for second, _ in enumerate(seconds):
            if second in (0, 2):
                assert ask("enable", "depth_center", second == 2) == [True, ""]
            if second == 3:
                assert ask("set", {"battery.enabled": True}) == [[True, ""]]
        return result(subscriber, folder)


def pauses(received: Received, camera: str) -> int:
    """Returns how often a camera delivered nothing for a second."""
    stamps_ns = [stamp_ns(it) for it in received.messages(f"{camera}/metadata")]
    assert len(stamps_ns) > 2 * 30
    return sum(later - earlier > 1e9 for earlier, later in itertools.pairwise(stamps_ns))


def test_only_the_changed_stream_restarts(tmp_path: Path) -> None:
    received = run(tmp_path)
    for topic in UNDISTURBED:
        counters = received.counters(f"{PREFIX}/{topic}")
        # Messages that a busy machine dropped were not lost by the reconfiguration.
        reasons = {key for key in counters if key.startswith("dropped.")} - {"dropped.link_down"}
        assert int(counters["gaps"]) == sum(int(counters[key]) for key in reasons), topic
    assert [pauses(received, camera) for camera in ("color", "depth")] == [0, 1]
    assert f"{PREFIX}/battery" in received.graph

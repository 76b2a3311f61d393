"""A camera that fails while it runs is reported by each command, and recovers by itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from configurations import only
from counters import assert_counters_agree
from processes import PREFIX, draw_images, headset_command, line_with
from waiting_receiver import WaitingReceiver, waiting_receiver

CONFIG = only("world_left: {enabled: true, format: jpeg}, other_sensors: {enabled: true}")
CAMERA = "android.permission.CAMERA"
GRANT = "ml2-receiver headset grant world_left"
# The running camera fails, and cannot be opened again for a while.
FAULTS = ("fault.world.get", "fault.world.permission")
BEGIN_S, END_S = 2, 20
MAX_POLLS = 60


def await_state(waiting: WaitingReceiver, state: str, reason: str = "") -> None:
    """Runs `devices` until world_left is in a state whose reason contains `reason`."""
    seen: list[dict[str, Any]] = []
    for _ in range(MAX_POLLS):
        device = json.loads(waiting.run("devices", "--json").stdout or "null")
        streams = [] if device is None else device["streams"]
        for stream in streams:
            if stream["stream"] == "world_left":
                seen.append(stream)
                if stream["state"] == state and reason in stream["reason"]:
                    return
    raise AssertionError(f"expected {state}, found {seen}")


def test_a_camera_that_fails_is_reported_and_recovers(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG)
    draw_images(config, (), tmp_path)
    options = [
        word
        for fault in FAULTS
        for value, at_s in ((1, BEGIN_S), (0, END_S))
        for word in ("--simulate", f"{fault}={value}@{at_s}")
    ]
    with (
        waiting_receiver(config, tmp_path) as waiting,
        waiting.started("headset", headset_command(waiting.address, *options)) as headset,
    ):
        line_with(headset, "world_left: waiting")
        await_state(waiting, "waiting", f"{CAMERA} is missing: run `{GRANT}`")
        doctor = waiting.run("doctor", "--json")
        (finding,) = [it for it in json.loads(doctor.stdout) if it["check"] == "streams"]
        assert (doctor.returncode, finding["level"]) == (1, "wrong")
        assert GRANT in finding["fix"]
        line_with(headset, "world_left: accepted")
        await_state(waiting, "runs")
        waiting.await_seconds(2)
        headset.terminate()
        received = waiting.result()
    assert_counters_agree(received)
    assert len(received.publishers[f"{PREFIX}/world_left/image_raw/compressed"]) == 1

"""Sources of every kind that fall silent are told by each command, opened again, and recover."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from processes import headset_command
from simulation import five_cameras
from waiting_receiver import WaitingReceiver, waiting_receiver

# One of each kind of source: world, depth, eye and colour cameras, poses, Android's sensors.
SILENT = (
    "world_left",
    "depth",
    "color",
    "head_pose",
    "gaze",
    "hand_left",
    "gyro_left",
    "magnetometer_left",
    "pressure_headset",
)
BEGIN_S, END_S = 4, 30
MAX_POLLS = 60


def await_states(waiting: WaitingReceiver, state: str, reason: str) -> None:
    """Polls `devices` until all of SILENT are in a state with a reason that begins so."""
    seen: dict[str, Any] = {}
    for _ in range(MAX_POLLS):
        device = json.loads(waiting.run("devices", "--json").stdout or "null")
        if device is not None:
            seen = {it["stream"]: it for it in device["streams"] if it["stream"] in SILENT}
            reached = [it["reason"] for it in seen.values() if it["state"] == state]
            if sum(it.startswith(reason) for it in reached) == len(SILENT):
                return
    raise AssertionError(f"expected {state}, found {seen}")


@pytest.mark.timeout(180)
def test_silent_sources_are_told_and_recover(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(five_cameras())
    silence = f"fault.silent={','.join(SILENT)}@{BEGIN_S}"
    options = ["--simulate", silence, "--simulate", f"fault.silent=@{END_S}"]
    with (
        waiting_receiver(config, tmp_path) as waiting,
        waiting.started("headset", headset_command(waiting.address, *options)) as headset,
    ):
        waiting.await_seconds(1)
        await_states(waiting, "waiting", "no capture for ")
        doctor = waiting.run("doctor", "--json")
        (finding,) = [it for it in json.loads(doctor.stdout) if it["check"] == "streams"]
        assert (doctor.returncode, finding["level"]) == (1, "wrong")
        assert all(stream in finding["found"] for stream in SILENT), finding
        assert "no capture for 4 s" in finding["found"]
        await_states(waiting, "runs", "")
        headset.terminate()
        waiting.result()

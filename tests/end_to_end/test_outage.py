"""A camera that fails while it runs is reported by each command, and recovers by itself."""

from __future__ import annotations

import json
from pathlib import Path

from configurations import only
from counters import assert_counters_agree, await_more
from processes import full_name, headset_command, line_with
from simulation import SIMULATE, STILL, simulate
from waiting import await_true
from waiting_receiver import WaitingReceiver, waiting_receiver

CONFIG = only("world_left: {enabled: true, format: jpeg}, other_sensors: {enabled: true}")
CAMERA = "android.permission.CAMERA"
GRANT = "ml2-receiver headset grant world_left"
# The running camera fails, and cannot be opened again for a while.
FAULTS = ("fault.world.get", "fault.world.permission")
IMAGE = "world_left/image_raw/compressed"


def await_state(waiting: WaitingReceiver, state: str, reason: str = "") -> None:
    """Runs `devices` until world_left is in a state whose reason contains `reason`."""

    def is_told() -> bool:
        device = json.loads(waiting.run("devices", "--json").stdout or "null")
        streams = [] if device is None else device["streams"]
        (found,) = [it for it in streams if it["stream"] == "world_left"] or [None]
        print(found)  # which pytest shows if the test fails
        return found is not None and found["state"] == state and reason in found["reason"]

    await_true(is_told)


def test_a_camera_that_fails_is_reported_and_recovers(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG)
    with (
        waiting_receiver(config, tmp_path) as waiting,
        waiting.started("headset", headset_command(waiting.address, *STILL, *SIMULATE)) as headset,
    ):
        await_more(waiting.subscriber, IMAGE)
        simulate(headset, "fault.world.gte=1")
        line_with(headset, 'unknown key "fault.world.gte"; the nearest is')
        simulate(headset, *(f"{it}=1" for it in FAULTS))
        line_with(headset, "world_left: waiting")
        await_state(waiting, "waiting", f"{CAMERA} is missing: run `{GRANT}`")
        doctor = waiting.run("doctor", "--json")
        (finding,) = [it for it in json.loads(doctor.stdout) if it["check"] == "streams"]
        assert (doctor.returncode, finding["level"]) == (1, "wrong")
        assert GRANT in finding["fix"]
        simulate(headset, *(f"{it}=0" for it in FAULTS))
        line_with(headset, "world_left: running")
        await_state(waiting, "runs")
        await_more(waiting.subscriber, IMAGE)
        headset.terminate()
        received = waiting.result()
    assert_counters_agree(received)
    assert len(received.publishers[full_name(IMAGE)]) == 1

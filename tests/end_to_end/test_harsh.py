"""A device with random faults on a bad link for 30 s; `make harsh` runs the same for an hour."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from harsh import filled_all_slots, harsh_run, write
from simulation import SMALL

DURATION_S = 30.0
# One camera of each kind sends raw images.
COMPRESSED = (
    "world_center",
    "world_right",
    "eye_nasal_right",
    "eye_temple_left",
    "eye_temple_right",
)


@pytest.fixture(scope="module", params=[1, 2], ids=["default_backends", "openxr"])
def results(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("harsh")
    results = harsh_run(
        DURATION_S,
        request.param,
        folder,
        picture_center=SMALL | {"update_rate": 15},
        depth_center={"stream": 0, "update_rate": 5},
        **{id: {"format": "jpeg"} for id in COMPRESSED},
    )
    write(results)
    log = (folder / "one" / "headset.log").read_text()
    assert "simulating fault." in log
    assert "simulating openxr.fault." in log
    assert results["link_faults"] > 0
    return results


def test_every_stream_comes_back(results: dict[str, Any]) -> None:
    assert results["alive_at_end"] == results["streams"]


def test_every_message_is_received_or_counted_as_dropped(results: dict[str, Any]) -> None:
    assert results["unaccounted"] == 0


def test_nothing_grows(results: dict[str, Any]) -> None:
    assert results["grown"] == [], results["slopes"]


@pytest.mark.parametrize(("latency_ms", "is_enough"), [(200.0, False), (250.0, True)])
def test_only_a_late_frame_explains_why_no_slot_was_free(
    latency_ms: float, is_enough: bool
) -> None:
    """Eight slots of a camera with 30 Hz are in use after 7 / 30 s."""
    stamps_s = np.arange(90) / 30
    latencies_ms = np.full(90, 20.0)
    latencies_ms[80] = latency_ms
    arrivals = np.column_stack([stamps_s + latencies_ms / 1e3, latencies_ms])
    assert filled_all_slots(arrivals, since_s=2.0) is is_enough
    assert not filled_all_slots(arrivals, since_s=3.0)

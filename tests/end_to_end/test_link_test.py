"""`ml2-receiver doctor` tries the link to a headset that streams."""

from __future__ import annotations

import json
import subprocess
from typing import Any

import pytest

from books import assert_books_balance
from processes import RECEIVER, Received, headset_command
from stage import Stage, staged

CONFIG = """
/ml2_receiver:
  ros__parameters:
    world_left: {enabled: true}
    other_sensors: {enabled: true}
"""
PATIENCE_S = 60.0


def doctor(stage: Stage) -> list[dict[str, Any]]:
    said = subprocess.run(
        [RECEIVER, "doctor", "--json"],
        env=stage.environment,
        stdout=subprocess.PIPE,
        text=True,
        timeout=PATIENCE_S,
        check=False,  # 1 when the machine has something else wrong
    )
    findings: list[dict[str, Any]] = json.loads(said.stdout)
    return findings


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Received]:
    """What doctor found of the link, and what arrived of the streams before, beside and after."""
    folder = tmp_path_factory.mktemp("link_test")
    config = folder / "config.yaml"
    config.write_text(CONFIG)
    with staged(config, folder) as stage:
        command = headset_command(stage.address, "--source", "test-signal")
        with stage.started("headset", command) as headset:
            stage.await_seconds(2)
            (link,) = [it for it in doctor(stage) if it["check"] == "link to headset"]
            headset.terminate()
            return link, stage.result()


def test_the_finding_says_what_is_free_and_what_the_streams_need(
    run: tuple[dict[str, Any], Received],
) -> None:
    link, _ = run
    numbers = link["numbers"]
    assert numbers["filler_bytes"] > 1 << 20
    assert numbers["free_mbit_per_s"] > 0
    assert numbers["streams_mbit_per_s"] > 0
    # One raw camera at 30 Hz, and what is small.
    assert 240 < numbers["needed_mbit_per_s"] < 270
    assert f"{numbers['free_mbit_per_s']:.1f} Mbit/s were free besides" in link["found"]
    assert bool(link["fix"]) == (link["level"] != "ok")


def test_the_streams_beside_it_lose_nothing_unaccounted(
    run: tuple[dict[str, Any], Received],
) -> None:
    _, received = run
    assert_books_balance(received)

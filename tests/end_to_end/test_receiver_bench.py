"""The receiver's benchmark runs, with and without a stand-in for the peer ROS-TCP-Endpoint."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from processes import ROOT, isolated_environment
from waiting import LIMIT_S

BENCH = ROOT / "tests" / "bench"
STAND_IN = Path(__file__).with_name("endpoint_stand_in")
FRAMES, REPETITIONS = 10, 1


@pytest.mark.parametrize("peer", ["", str(STAND_IN)])
def test_the_benchmark_measures_a_peer_if_there_is_one(tmp_path: Path, peer: str) -> None:
    file = tmp_path / "receiver.json"
    run("receiver_bench.py", file, FRAMES, REPETITIONS, environment={"PEER": peer})
    found = json.loads(file.read_text())
    assert found["lost"] == found["bare_lost"] == 0
    assert found["ratio_to_bare"] > 0
    if peer:
        assert found["endpoint_cpu_ms_per_frame"] > 0
        # The peer drops messages if the subscriber is too slow on a busy machine.
        assert found["endpoint_lost"] < (1 + REPETITIONS) * FRAMES
    else:
        assert found["endpoint"] == "not compared; make bench PEER=<checkout of ROS-TCP-Endpoint>"


def test_the_benchmark_of_the_way_back_compares_with_a_peer(tmp_path: Path) -> None:
    file = tmp_path / "downlink_endpoint.json"
    run("downlink_endpoint_bench.py", file, STAND_IN, 0.2, REPETITIONS)
    found = json.loads(file.read_text())
    for size in ("small", "large"):
        assert found[f"receiver_{size}_latency_p50_ms"] > 0
        assert found[f"endpoint_{size}_latency_p50_ms"] > 0
        assert found[f"ratio_to_endpoint_{size}"] > 0


def run(name: str, *arguments: object, environment: Mapping[str, str] | None = None) -> None:
    folders = "host_receiver", "host_receiver/demo", "host_receiver/test", "tests/end_to_end"
    environment = {
        **isolated_environment(),
        **(environment or {}),
        "PYTHONPATH": os.pathsep.join(str(ROOT / it) for it in folders),
    }
    command = [sys.executable, str(BENCH / name), *map(str, arguments)]
    subprocess.run(command, env=environment, check=True, timeout=LIMIT_S)

"""The receiver's benchmark runs, with and without a stand-in for the peer ROS-TCP-Endpoint."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from processes import ROOT, isolated_environment
from waiting import LIMIT_S

BENCH = ROOT / "tests" / "bench" / "receiver_bench.py"
STAND_IN = Path(__file__).with_name("endpoint_stand_in")
FRAMES, REPETITIONS = 10, 1


@pytest.mark.parametrize("peer", ["", str(STAND_IN)])
def test_the_benchmark_measures_a_peer_if_there_is_one(tmp_path: Path, peer: str) -> None:
    paths = [ROOT / "host_receiver", ROOT / "host_receiver" / "test"]
    environment = isolated_environment() | {
        "PEER": peer,
        "PYTHONPATH": os.pathsep.join(map(str, paths)),
    }
    file = tmp_path / "receiver.json"
    command = [sys.executable, str(BENCH), str(file), str(FRAMES), str(REPETITIONS)]
    subprocess.run(command, env=environment, check=True, timeout=LIMIT_S)
    found = json.loads(file.read_text())
    assert found["lost"] == found["bare_lost"] == 0
    assert found["ratio_to_bare"] > 0
    if peer:
        assert found["endpoint_cpu_ms_per_frame"] > 0
        # The peer drops messages if the subscriber is too slow on a busy machine.
        assert found["endpoint_lost"] < (1 + REPETITIONS) * FRAMES
    else:
        assert found["endpoint"] == "not compared; make bench PEER=<checkout of ROS-TCP-Endpoint>"

"""docs/add_a_sensor.md, done as it says."""

from __future__ import annotations

import shutil
import subprocess
from itertools import pairwise
from pathlib import Path

import pytest

from beside import collect
from capture_stamps import stamp_ns
from document import ROOT, blocks, commands, files
from processes import IN_THE_CLEAR, isolated_environment, listening_address, process

DOCUMENT = (ROOT / "docs" / "add_a_sensor.md").read_text()
GENERATE = "host_receiver/environment/run.sh python3 config/generate.py"
# What `make build` does for these two; tests, packages and the app are not needed.
COMPILE = "mvn -o -q package -Dmaven.test.skip=true -pl ml2-sensors-aar,ml2-sensors-aar/simulator"


def copy_of_this_tree(folder: Path) -> Path:
    for file in files():
        copy = folder / file.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(file, copy, follow_symlinks=False)
    (folder / "build").symlink_to(ROOT / "build")
    return folder


@pytest.mark.timeout(900)
def test_a_sensor_is_a_topic_after_what_the_document_says(tmp_path: Path) -> None:
    tree = copy_of_this_tree(tmp_path / "tree")
    differences = "".join(blocks(DOCUMENT, "diff"))
    subprocess.run(["git", "init", "-q"], cwd=tree, check=True)
    subprocess.run(["git", "apply"], cwd=tree, input=differences, text=True, check=True)
    assert GENERATE in commands(DOCUMENT)
    for command in (GENERATE, COMPILE):
        subprocess.run(command.split(), cwd=tree, check=True)

    config = tmp_path / "thermometer.yaml"
    config.write_text("".join(blocks(DOCUMENT, "yaml")))
    environment = isolated_environment()
    run: list[str | Path] = [tree / "host_receiver/ml2-receiver", "run", "--config", config]
    run += ["--listen", "127.0.0.1:0", *IN_THE_CLEAR.receiver]
    with process(run, environment, tmp_path / "receiver.log") as receiver:
        headset: list[str | Path] = [
            tree / "ml2-sensors-aar/simulator/ml2-headset",
            *IN_THE_CLEAR.headset,
        ]
        headset += ["--receiver", listening_address(receiver), "--source", "test-signal"]
        with process(headset, environment, tmp_path / "headset.log"):
            received = collect(
                {"temperature": "sensor_msgs/msg/Temperature"}, 5, environment, tmp_path
            )

    readings = received.messages("temperature")
    assert {it.header.frame_id for it in readings} == {"head_frame"}
    assert all(21 <= it.temperature <= 23 and it.variance == 0 for it in readings)
    assert all(stamp_ns(a) < stamp_ns(b) for a, b in pairwise(readings))

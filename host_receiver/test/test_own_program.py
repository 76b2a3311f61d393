"""The program of the README, run as the README says."""

import subprocess
from pathlib import Path

import bag_scene
from configurations import only
from document import ROOT, blocks, commands
from mock_device import MockDevice
from repeated import repeated
from ros_processes import environment

README = (ROOT / "README.md").read_text()
COMMAND = "host_receiver/environment/run.sh python3 my_program.py"
CONFIG = only("world_center: {enabled: true, format: jpeg}")


def test_it_gets_images_of_a_headset(device: MockDevice, tmp_path: Path) -> None:
    (code,) = blocks(README, "python")
    assert COMMAND in commands(README)
    (tmp_path / "my_program.py").write_text(code)
    run, *arguments = COMMAND.split()
    image = bag_scene.jpeg(3)
    with (
        repeated(lambda: device.publish("world_center/image_raw/compressed", image), 0.05),
        subprocess.Popen(
            [ROOT / run, *arguments],
            cwd=tmp_path,
            env=environment(),
            stdout=subprocess.PIPE,
            text=True,
        ) as program,
    ):
        assert program.stdout is not None
        try:
            line = program.stdout.readline()
        finally:
            program.terminate()
    assert line.startswith("3 world_left_optical_frame mono8; jpeg compressed mono8 ")

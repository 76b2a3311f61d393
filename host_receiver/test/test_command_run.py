import os
import re
import signal
import socket
from pathlib import Path

import pytest

from ml2_receiver.cli import main
from mock_device import MockDevice
from ros_processes import Child, Receiver

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = """
/**:
  ros__parameters:
    world_left: {enabled: true}
    battery: {enabled: true}
"""


def segments(process: int) -> list[Path]:
    """Its shared memory; the ports beside it belong to all participants of a domain."""
    maps = Path(f"/proc/{process}/maps").read_text()
    return [Path(name) for name in re.findall(r"/dev/shm/fastrtps_(?!port)\w+", maps)]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_and_frees_shared_memory(config: Path, number: int) -> None:
    with Receiver(config) as receiver, MockDevice(receiver.address, says_ping=True) as device:
        device.start()
        shared = segments(receiver.process.pid)
        assert shared
        assert receiver.end(number) == 0
        assert [file for file in shared if file.exists()] == []


def test_it_says_who_came_what_runs_and_what_does_not(config: Path) -> None:
    with Receiver(config) as receiver, MockDevice(receiver.address, says_ping=True) as device:
        device.start(refused={"world_left": "no permission"})
        device.leave()
        receiver.end()
        said = "\n".join(receiver.errors)
        assert "'device name' connected from 127.0.0.1:" in said
        assert "world_left refused: 'no permission'" in said
        assert "streams: battery, tf" in said
        assert "session ended" in said


def test_a_wrong_configuration_ends_it_before_it_listens(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "config.yaml"
    file.write_text("/**: {ros__parameters: {gaze: {enabled: 1}}}")
    assert main(["run", "--config", str(file)]) == 2
    printed = capsys.readouterr()
    assert "gaze.enabled" in printed.err
    assert printed.out == ""


def test_arguments_that_ros_does_not_take_end_it(config: Path) -> None:
    command = ("-m", "ml2_receiver", "run", "--config", str(config), "--listen", "127.0.0.1:0")
    with Child(*command, "--ros-args", "-p", "nonsense") as child:
        assert child.wait() == 2
        assert any("ROS 2 does not start" in line for line in child.errors)


def test_a_port_in_use_ends_it(config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        assert main(["run", "--config", str(config), "--listen", address]) == 2
    error = capsys.readouterr().err
    first, hint = error.splitlines()
    assert first.startswith(f"cannot listen on {address}: the port is used by ")
    assert first.endswith(f"(pid {os.getpid()})")
    assert hint == "hint: Stop it, or choose another port with --listen."


@pytest.mark.parametrize("address", ["7755", "localhost", "localhost:", ":1", "a:-1"])
def test_an_address_has_a_host_and_a_port(address: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["run", "--listen", address])
    assert f"expected HOST:PORT, found '{address}'" in capsys.readouterr().err


def test_an_address_has_a_port_that_there_is(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["run", "--listen", "127.0.0.1:99999"])
    expected = "expected a port from 0 to 65535, found 99999 in '127.0.0.1:99999'"
    assert expected in capsys.readouterr().err


@pytest.mark.parametrize(
    ("section", "options", "words"),
    [
        ("", [], "images need about 248 Mbit/s"),
        ("eye_nasal_left: {enabled: true}", [], "images need about 248 Mbit/s"),
        (
            "eye_nasal_left: {enabled: true}",
            ["--insecure-eye-images"],
            "images need about 286 Mbit/s",
        ),
        ("general: {link: 300}", [], "images need about 248 Mbit/s, within the link's 300"),
    ],
)
def test_it_says_what_the_images_that_it_asks_for_need(
    config: Path, section: str, options: list[str], words: str
) -> None:
    config.write_text(f"{config.read_text()}    {section}\n")
    command = ("-m", "ml2_receiver", "run", "--config", str(config), "--listen", "127.0.0.1:0")
    with Child(*command, "--insecure", *options) as child:
        assert child.line().startswith("listening on ")
        assert child.line() == f"configuration: {config}"
        assert child.line() == words

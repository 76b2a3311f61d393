import re
import signal
from pathlib import Path

import pytest

from command_line import refusal
from configurations import only
from ml2_receiver.cli import main
from mock_device import MockDevice
from ros_processes import Child, Receiver, segments

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("world_left: {enabled: true}, battery: {enabled: true}")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.usefixtures("device")
def test_a_signal_ends_it_and_frees_shared_memory(receiver: Receiver, number: int) -> None:
    shared = segments(receiver.process.pid)
    assert max(it.stat().st_size for it in shared) > 64 << 20  # for images
    assert receiver.end(number) == 0
    assert [file for file in shared if file.exists()] == []


def test_it_says_who_came_what_runs_and_what_does_not(receiver: Receiver) -> None:
    with MockDevice(receiver.address, says_ping=True) as device:
        device.start(refused={"world_left": "no permission"})
        device.leave()
    receiver.end()
    said = "\n".join(receiver.errors)
    assert "'device name' connected from 127.0.0.1:" in said
    assert "world_left refused: 'no permission'" in said
    assert "streams: battery, tf" in said
    assert "session ended" in said


def test_logs_of_ros_are_no_lines_of_its_output(
    config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RCUTILS_LOGGING_USE_STDOUT", "1")
    monkeypatch.setenv("ROS_LOCALHOST_ONLY", "1")  # of which ROS warns
    with Receiver(config) as receiver:
        assert re.fullmatch(r"127\.0\.0\.1:\d+", receiver.address)
        receiver.await_error("ROS_LOCALHOST_ONLY is deprecated")


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


@pytest.mark.parametrize("address", ["7755", "localhost", "localhost:", ":1", "a:-1"])
def test_an_address_has_a_host_and_a_port(address: str) -> None:
    assert f"expected HOST:PORT, found '{address}'" in refusal("run", "--listen", address)


def test_an_address_has_a_port_that_there_is() -> None:
    expected = "expected a port from 0 to 65535, found 99999 in '127.0.0.1:99999'"
    assert expected in refusal("run", "--listen", "127.0.0.1:99999")


@pytest.mark.parametrize(
    ("section", "options", "words"),
    [
        ("", [], "images need about 248 Mbit/s"),
        ("eye_nasal_left: {enabled: true, format: Grayscale}", [], "images need about 248 Mbit/s"),
        (
            "eye_nasal_left: {enabled: true, format: Grayscale}",
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

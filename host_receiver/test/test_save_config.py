"""Eye cameras and the configuration file, as anybody in the ROS domain meets them."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from configurations import only
from ml2_receiver.configuration.config import load_config
from mock_device import MockDevice
from ros_processes import Client, Receiver

pytest.importorskip("rclpy", reason="rclpy is not installed")

EYES_IN_THE_CLEAR = "--insecure-eye-images"
CONFIG = f"# mine\n{only('world_left: {enabled: true}')}"
EYE = "eye_nasal_left"
ALLOWED = f"{CONFIG}    general: {{eye_cameras: allowed}}\n"


@pytest.fixture
def receiver(config: Path) -> Iterator[Receiver]:
    with Receiver(config, EYES_IN_THE_CLEAR) as receiver:
        yield receiver


def save(client: Client, *names: str) -> tuple[bool, str]:
    assert client.ask("set", {"save.keys": " ".join(names)}) == [[True, ""]]
    is_saved, said = client.ask("trigger", "save_config")
    assert client.ask("get", "save.keys") == [""]
    return is_saved, said


def test_no_service_switches_on_an_eye_camera_until_the_file_allows_it(
    client: Client, device: MockDevice, config: Path
) -> None:
    (once,) = client.ask("set", {f"{EYE}.enabled": True})
    for is_set, said in (
        once,
        client.ask("enable", EYE, True),
        client.ask("set_atomically", {"tf.layout": "rig", f"{EYE}.enabled": True}),
        client.ask("set_atomically", {"general.eye_cameras": "allowed", f"{EYE}.enabled": True}),
    ):
        assert not is_set
        assert "write general.eye_cameras: allowed" in said
    names = ("tf.layout", f"{EYE}.enabled", "general.eye_cameras")
    assert client.ask("get", *names) == ["flat", False, "refused"]
    config.write_text(ALLOWED)
    assert client.ask("trigger", "reload") == [True, ""]
    assert client.ask("enable", EYE, True) == [True, ""]
    asked = device.reconfigure()
    assert EYE in asked.streams
    device.expect_start(asked.request)
    config.write_text(CONFIG)
    assert client.ask("trigger", "reload") == [True, ""]
    assert EYE not in device.reconfigure().streams
    assert not client.ask("enable", EYE, True)[0]


def test_the_arguments_of_the_start_are_the_operators_own(config: Path, tmp_path: Path) -> None:
    file = tmp_path / "more.yaml"
    file.write_text(f"/ml2_receiver: {{ros__parameters: {{{EYE}: {{enabled: true}}}}}}")
    options = (EYES_IN_THE_CLEAR, "--ros-args", "--params-file", str(file))
    with Receiver(config, *options) as receiver, Client() as client:
        with MockDevice(receiver.address, says_ping=True) as device:
            assert EYE in device.reach_configure().streams
        assert client.ask("enable", EYE, False) == [True, ""]
        assert client.ask("enable", EYE, True) == [True, ""]
        assert not client.ask("enable", "eye_nasal_right", True)[0]
        is_saved, said = save(client, f"{EYE}.enabled")
        assert (is_saved, "images of eyes are biometric" in said) == (False, True)
    assert config.read_text() == CONFIG


def test_what_others_have_set_is_kept_only_by_name(
    client: Client, config: Path, receiver: Receiver
) -> None:
    assert client.ask("set_atomically", {"tf.layout": "rig", "battery.enabled": True})[0]
    is_saved, said = client.ask("trigger", "save_config")
    assert not is_saved
    assert "not as in the file are battery.enabled, tf.layout" in said
    assert config.read_text() == CONFIG
    assert save(client, "tf.layout") == (True, f"written to {config}")
    values = load_config(config).values
    assert (values["tf.layout"], values["battery.enabled"]) == ("rig", False)
    is_saved, said = client.ask("trigger", "save_config")
    assert (is_saved, "are battery.enabled: " in said) == (False, True)
    assert client.ask("trigger", "reload") == [True, ""]
    assert client.ask("get", "tf.layout", "battery.enabled") == ["rig", False]
    assert client.ask("trigger", "save_config")[0]


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["tf.layuot"], "found tf.layuot; did you mean tf.layout?"),
        (["tf"], "found tf"),
        (["tf.layout", "x" * 100_000], f"found {'x' * 60}"),
        (["general.eye_cameras", f"{EYE}.enabled", "*"], "found *"),
    ],
)
def test_a_name_that_is_no_key_writes_nothing(
    client: Client, config: Path, names: list[str], said: str
) -> None:
    is_saved, found = save(client, *names)
    assert (is_saved, said in found, len(found) < 2000) == (False, True, True), found
    assert config.read_text() == CONFIG

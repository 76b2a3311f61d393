"""Commands that need a receiver say what to start where none runs."""

from pathlib import Path
from types import ModuleType

import pytest

from command_line import refusal
from ml2_tools.commands import call, devices, latency, record_attached, topics, view
from terminal import OnTerminal

pytest.importorskip("rclpy", reason="rclpy is not installed")


@pytest.mark.processes
@pytest.mark.usefixtures("ros_of_children")
@pytest.mark.parametrize(
    ("module", "words"),
    [
        (call, "call stop"),
        (devices, "devices"),
        (latency, "latency --once"),
        (record_attached, "record walk --attach"),
        (topics, "topics"),
        (view, "view --no-browser"),
    ],
)
def test_without_a_receiver_it_says_what_to_start(
    module: ModuleType, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, "PATIENCE_S", 0.5)
    error, hint = refusal(*words.split()).splitlines()
    assert error.startswith("no receiver in ")
    assert hint.startswith("hint: Start `ml2-receiver run`")
    assert not list(tmp_path.iterdir()), "nothing is recorded"


@pytest.mark.processes
@pytest.mark.parametrize(
    ("words", "what"),
    [
        ("devices", "the receiver desk"),
        ("topics", "the receiver desk"),
        ("set battery.enabled=true", "the receiver desk"),
        ("record walk --attach", "the receiver desk"),
        ("view --no-browser", "the receiver desk"),
        ("latency", "messages of the receiver desk"),
        ("echo /nobody", "a publisher of /nobody"),
    ],
)
def test_a_terminal_shows_at_once_what_is_looked_for_and_for_how_long(
    words: str, what: str
) -> None:
    with OnTerminal(*words.split(), "--name", "desk") as child:
        child.await_shown(rf"looking for {what} in ROS domain \d+,\s+for up to 10 s".encode())
        assert child.process.poll() is None, "it looks after it has said so"


@pytest.mark.processes
@pytest.mark.usefixtures("ros_of_children")
@pytest.mark.parametrize(
    "words",
    [
        "run --insecure --listen 127.0.0.1:0",
        "products",
        "compat",
        "topics",
        "export --kalibr out",
        "evaluate --live --camera world_left --out out",
    ],
)
def test_a_middleware_that_does_not_start_is_an_error(
    words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As one without the security that the environment wants, or with a wrong keystore."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "enclaves").mkdir()
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    monkeypatch.setenv("ROS_SECURITY_STRATEGY", "Enforce")
    monkeypatch.setenv("ROS_SECURITY_KEYSTORE", str(tmp_path))
    said = refusal(*words.split())
    assert "ROS 2 does not start: " in said
    assert "ROS_SECURITY_*" in said.splitlines()[-1]

"""The wheel of `make dist`, installed into an environment that has only what it requires."""

import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from queue import SimpleQueue

import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

import wheel_environment
from bags import message_counts
from dist import DIST, ROOT, VERSION
from waiting import LIMIT_S, await_true
from zenoh_peers import free_endpoint, open_router

HEADSET = ROOT / "ml2-sensors-aar/simulator/ml2-headset"
CONFIG = """
/**:
  ros__parameters:
    world_center: {enabled: false}
    battery: {enabled: true}
"""
TOPICS = {"/magic_leap2/gyro_left/imu", "/magic_leap2/battery"}
LISTENING = "listening on "


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    (wheel,) = DIST.glob("*.whl")
    return wheel_environment.make(tmp_path_factory.mktemp("installed") / "venv", wheel)


@pytest.fixture(scope="module")
def python_with_zenoh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    (wheel,) = DIST.glob("*.whl")
    folder = tmp_path_factory.mktemp("with_zenoh") / "venv"
    return wheel_environment.make(folder, wheel, "zenoh")


@pytest.fixture
def receiver(python: Path) -> Path:
    return python.with_name("ml2-receiver")


@pytest.fixture
def config(tmp_path: Path) -> Path:
    file = tmp_path / "config.yaml"
    file.write_text(CONFIG)
    return file


def elsewhere(folder: Path) -> dict[str, str]:
    """Variables without those by which Python finds other packages, and another user's home."""
    paths = ("PYTHONPATH", "AMENT_PREFIX_PATH", "LD_LIBRARY_PATH", "VIRTUAL_ENV")
    return {k: v for k, v in os.environ.items() if k not in paths} | {"HOME": str(folder)}


def output(folder: Path, *command: str | Path) -> str:
    done = subprocess.run(
        command, cwd=folder, env=elsewhere(folder), check=False, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def feed(receiving: subprocess.Popen[str], folder: Path, is_enough: Callable[[], bool]) -> str:
    """Streams a simulated headset to a receiver until there is enough, and ends both.

    Returns what the receiver still said.
    """
    assert receiving.stdout is not None
    address = next(line.split()[2] for line in receiving.stdout if line.startswith(LISTENING))
    try:
        headset: list[str | Path] = [HEADSET, "--receiver", address, "--insecure"]
        with (folder / "headset.log").open("w") as log:
            streaming = subprocess.Popen(headset, stdout=log, stderr=log)
        try:
            await_true(is_enough)
        finally:
            streaming.terminate()
            assert streaming.wait(LIMIT_S) == 0
    finally:
        receiving.send_signal(signal.SIGINT)
        rest, _ = receiving.communicate(timeout=LIMIT_S)
    return rest


def test_the_environment_has_the_wheels_packages_and_no_ros(python: Path, tmp_path: Path) -> None:
    look = "import importlib.util as u; print(u.find_spec('{}'))"
    found = output(tmp_path, python, "-c", look.format("ml2_receiver"))
    assert str(python.parents[1]) in found
    assert output(tmp_path, python, "-c", look.format("rclpy")) == "None\n"
    assert output(tmp_path, python, "-c", look.format("pytest")) == "None\n"


def test_it_says_its_version(receiver: Path, tmp_path: Path) -> None:
    assert output(tmp_path, receiver, "--version") == f"{VERSION}\n"


def test_it_checks_a_configuration(receiver: Path, config: Path) -> None:
    assert "gyro_left/imu" in output(config.parent, receiver, "config", "check", config)


def test_a_session_without_ros_is_recorded(receiver: Path, config: Path, tmp_path: Path) -> None:
    walk = tmp_path / "walk"
    options = ("--no-ros", "--insecure", "--listen", "127.0.0.1:0", "--config", config)
    command: list[str | Path] = [receiver, "record", walk, *options]
    with (
        (tmp_path / "receiver.log").open("w+") as errors,
        subprocess.Popen(
            command,
            cwd=tmp_path,
            env=elsewhere(tmp_path),
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        ) as recording,
    ):
        rest = feed(recording, tmp_path, lambda: all(message_counts(walk).get(it) for it in TOPICS))
        errors.seek(0)
        assert recording.returncode == 0, errors.read()
    assert f"recorded into {walk}" in rest
    with Reader(walk) as bag:
        counts = {connection.topic: connection.msgcount for connection in bag.connections}
    assert all(counts[topic] > 0 for topic in TOPICS)


def test_it_publishes_on_zenoh_without_ros(
    python_with_zenoh: Path, config: Path, tmp_path: Path
) -> None:
    look = "import importlib.util as u; print(u.find_spec('rclpy'), u.find_spec('sensor_msgs'))"
    assert output(tmp_path, python_with_zenoh, "-c", look) == "None None\n"
    endpoint = free_endpoint()
    options = ("--no-ros", "--insecure", "--listen", "127.0.0.1:0", "--config", config)
    command: list[str | Path] = [python_with_zenoh.with_name("ml2-receiver"), "run", *options]
    samples: SimpleQueue[bytes] = SimpleQueue()
    with (
        open_router(endpoint) as router,
        subprocess.Popen(
            [*command, "--zenoh", endpoint],
            cwd=tmp_path,
            env=elsewhere(tmp_path) | {"ROS_DOMAIN_ID": "3"},
            stdout=subprocess.PIPE,
            text=True,
        ) as receiving,
    ):
        router.declare_subscriber(
            "3/magic_leap2/gyro_left/imu/**", lambda it: samples.put(it.payload.to_bytes())
        )
        feed(receiving, tmp_path, lambda: samples.qsize() > 100)
        assert receiving.returncode == 0
    get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(samples.get(), "sensor_msgs/msg/Imu")

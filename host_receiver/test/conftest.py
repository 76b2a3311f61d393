"""Fixtures of several modules, and how patient all tests are."""

import functools
import os
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
import zenoh
from hypothesis import HealthCheck, settings

import bag_scene
from ml2_receiver.session.settings import Limits
from mock_device import MockDevice
from repeated import begin
from ros_processes import Client, Receiver, environment
from secure_receiver import LIMITS, OpenLab, SecureReceiver
from zenoh_peers import free_endpoint, open_router

# A busy machine draws data slowly, which proves nothing about the code under test.
settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")


# A module that imports one of these starts processes or ROS.
_SLOW = {
    "adb_stand_in",
    "rclpy",
    "ros_client",
    "ros_processes",
    "ros_subscriber",
    "subprocess",
    "wall_walk",
}


def pytest_collection_modifyitems(items: list[pytest.Function]) -> None:
    """Marks the tests of modules that start processes: `make check` leaves them out."""
    for item in items:
        if _is_slow(item.module):
            item.add_marker("processes")


@functools.cache
def _is_slow(module: ModuleType) -> bool:
    used = {getattr(it, "__module__", None) or str(it) for it in vars(module).values()}
    return bool({re.sub(r"^<module '|[.'].*", "", name) for name in used} & _SLOW)


@pytest.fixture(autouse=True)
def priority() -> Iterator[None]:
    """A command that a test runs in this process leaves its priority, for it stays with all."""
    before = os.getpriority(os.PRIO_PROCESS, 0)
    yield
    assert os.getpriority(os.PRIO_PROCESS, 0) == before


@pytest.fixture
def ros_of_children(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nodes of this process find those of its children."""
    for name in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
        monkeypatch.setenv(name, environment()[name])


@pytest.fixture
def config(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """A file that says what the module's CONFIG does."""
    file = tmp_path / "config.yaml"
    file.write_text(request.module.CONFIG)
    return file


@pytest.fixture
def receiver(config: Path) -> Iterator[Receiver]:
    """A running one with that configuration."""
    with Receiver(config) as receiver:
        yield receiver


@pytest.fixture
def client(receiver: Receiver) -> Iterator[Client]:
    """A client of the receiver's services."""
    with Client() as client:
        yield client


@pytest.fixture
def device(receiver: Receiver) -> Iterator[MockDevice]:
    """Its headset, which was let run."""
    with MockDevice(receiver.address, says_ping=True) as device:
        begin(device)
        yield device


@pytest.fixture
def app(config: Path) -> Iterator[MockDevice]:
    """A headset whose app may do what the module's CONFIG allows, which was let run."""
    with (
        Receiver(config, "--insecure-control") as receiver,
        MockDevice(receiver.address, says_ping=True, has_ros=True) as app,
    ):
        begin(app)
        yield app


@pytest.fixture(scope="session")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of the scene's first messages."""
    folder = tmp_path_factory.mktemp("bags") / "walk"
    bag_scene.record(folder, bag_scene.COUNT, "zstd")
    return folder


@pytest.fixture
def open_lab(tmp_path: Path) -> Iterator[OpenLab]:
    labs: list[SecureReceiver] = []

    def make(limits: Limits) -> SecureReceiver:
        labs.append(SecureReceiver(tmp_path, limits))
        return labs[-1]

    yield make
    for secure in labs:
        secure.stop()


@pytest.fixture
def secure(open_lab: OpenLab) -> SecureReceiver:
    return open_lab(LIMITS)


@pytest.fixture
def endpoint() -> str:
    """A free endpoint for a router of Zenoh."""
    return free_endpoint()


@pytest.fixture
def router(endpoint: str) -> Iterator[zenoh.Session]:
    with open_router(endpoint) as router:
        yield router

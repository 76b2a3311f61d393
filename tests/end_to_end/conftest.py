"""The sessions of every simulated sensor that several modules look at, and how headsets start."""

from __future__ import annotations

import os

import pytest

from full_load import FullLoad, full_load
from processes import Received


@pytest.fixture(autouse=True, scope="session")
def quick_start() -> None:
    """Headsets live for seconds here, too short for what HotSpot's second compiler costs."""
    os.environ["JDK_JAVA_OPTIONS"] = "-XX:TieredStopAtLevel=1"


@pytest.fixture(scope="session")
def flat(tmp_path_factory: pytest.TempPathFactory) -> FullLoad:
    return full_load("flat", tmp_path_factory.mktemp("flat"))


@pytest.fixture(scope="session")
def rig(tmp_path_factory: pytest.TempPathFactory) -> FullLoad:
    return full_load("rig", tmp_path_factory.mktemp("rig"))


@pytest.fixture(scope="session")
def received(flat: FullLoad) -> Received:
    return flat.received

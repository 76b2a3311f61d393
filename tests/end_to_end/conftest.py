"""Sessions with all simulated sensors, which several test modules share."""

from __future__ import annotations

import pytest

from full_load import FullLoad, full_load
from processes import Received


@pytest.fixture(scope="session")
def flat(tmp_path_factory: pytest.TempPathFactory) -> FullLoad:
    return full_load("flat", tmp_path_factory.mktemp("flat"))


@pytest.fixture(scope="session")
def rig(tmp_path_factory: pytest.TempPathFactory) -> FullLoad:
    return full_load("rig", tmp_path_factory.mktemp("rig"))


@pytest.fixture(scope="session")
def received(flat: FullLoad) -> Received:
    return flat.received

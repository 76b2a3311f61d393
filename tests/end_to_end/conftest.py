"""The run of every simulated sensor that several modules look at."""

from __future__ import annotations

import pytest

from processes import Received, receive
from simulation import demo_config


@pytest.fixture(scope="session")
def received(tmp_path_factory: pytest.TempPathFactory) -> Received:
    folder = tmp_path_factory.mktemp("simulated")
    config = folder / "everything.yaml"
    config.write_text(demo_config(depth_center={"confidence": True, "flags": True}))
    return receive(config, ["--duration", "3"], folder)

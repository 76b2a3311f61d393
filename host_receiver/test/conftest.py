"""What all tests need."""

import os

import pytest
from hypothesis import HealthCheck, settings

# How long a busy machine takes to make up data proves nothing about what is tested with it.
settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")


@pytest.fixture(autouse=True, scope="session")
def home_of_configuration(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keeps tests away from the user's keys and configuration."""
    os.environ["XDG_CONFIG_HOME"] = str(tmp_path_factory.mktemp("config"))

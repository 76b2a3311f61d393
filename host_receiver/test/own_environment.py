"""A plugin of pytest: tests are alike in each user's shell, and after each other."""

import os
from collections.abc import Iterator

import pytest

# ROS and its middleware, Java, proxies, and how programs print
_PREFIXES = ("CYCLONEDDS_", "FASTDDS_", "FASTRTPS_", "RCUTILS_", "RMW_", "ROS_", "ZENOH_", "LC_")
_NAMES = {
    *("JAVA_TOOL_OPTIONS", "JDK_JAVA_OPTIONS", "_JAVA_OPTIONS"),
    *("ALL_PROXY", "HTTP_PROXY", "HTTPS_PROXY", "all_proxy", "http_proxy", "https_proxy"),
    *("COLUMNS", "FORCE_COLOR", "LANG", "LANGUAGE", "LINES", "NO_COLOR", "TZ"),
}
# They say which ROS is installed.
_KEPT = {"ROS_DISTRO", "ROS_PYTHON_VERSION", "ROS_VERSION"}

for name in [*os.environ]:
    if name in _NAMES or (name.startswith(_PREFIXES) and name not in _KEPT):
        del os.environ[name]


@pytest.fixture(autouse=True, scope="session")
def home_of_configuration(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keeps tests away from the user's keys and configuration."""
    os.environ["XDG_CONFIG_HOME"] = str(tmp_path_factory.mktemp("config"))


@pytest.fixture(autouse=True)
def environment_of_a_test(home_of_configuration: None) -> Iterator[None]:
    """Fails the test that leaves a variable to those after it."""
    before = _variables()
    yield
    after = _variables()
    changed = {name for name, _ in before.items() ^ after.items()}
    for name in changed:
        os.environ.pop(name, None)
        if name in before:
            os.environ[name] = before[name]
    assert not changed, "the test has left these variables changed"


def _variables() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}

"""A plugin of pytest: tests are alike in each user's shell or script, and after each other."""

import os
import signal
import subprocess
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

# Root of a container may often do neither.
_UNSHARE = ("unshare", "--mount", "--net", "true")
MAY_MOUNT_AND_MAKE_NETWORKS = (
    os.geteuid() == 0 and subprocess.run(_UNSHARE, capture_output=True, check=False).returncode == 0
)

for name in [*os.environ]:
    if name in _NAMES or (name.startswith(_PREFIXES) and name not in _KEPT):
        del os.environ[name]

# In the background of a script a command ignores it, and so would all that tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="session")
def home_of_configuration(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keeps tests away from the user's keys and configuration."""
    os.environ["XDG_CONFIG_HOME"] = str(tmp_path_factory.mktemp("config"))


@pytest.fixture(autouse=True)
def variables_of_a_test() -> Iterator[None]:
    """Leaves nothing of what a test sets, or a command in its process, to the tests after it."""
    before = dict(os.environ)
    yield
    for name in os.environ.keys() - before.keys():
        del os.environ[name]
    for name, value in before.items() - os.environ.items():
        os.environ[name] = value

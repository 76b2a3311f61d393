"""The table in SECURITY.md of what was tried: the names of tests, as sentences."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

_PYTHON = "host_receiver/test"
_KOTLIN = "ml2-sensors-aar/src/test/kotlin/dev/ml2sensors"
# The attackers, and the test files of each: in _PYTHON, or in _KOTLIN with their folder.
_TRIED = {
    "anybody on the network": (
        "test_malicious_peers",
        "test_address_limits",
        "test_pairing_listener",
        "test_secure_server",
        "test_discovery",
    ),
    "a paired headset": (
        "test_frame",
        "test_messages",
        "test_event_limit",
        "test_printable",
        "test_app_rules",
        "test_custom_topics",
        "test_openings",
        "test_ros_subscriptions",
        "test_app_services",
        "test_ros_services",
    ),
    "a receiver, to a headset": (
        "wire/PrintableTest",
        "session/DiscoveredReceiverTest",
        "stream/Ml2StreamerTest",
        "stream/BackOffTest",
    ),
    "a receiver, to `play`": ("test_play_extremes",),
    "whoever made a file that is read": (
        "test_bag_forms",
        "test_calibration",
        "test_special_files",
        "test_images",
    ),
    "another node of the ROS domain": (
        "test_eye_cameras",
        "test_save_config",
        "test_callback_failures",
        "test_viewing_hostile",
        "test_hostile_peers",
    ),
    "a subscriber in ROS or on Zenoh": ("test_demand",),
    "a browser, or a program of this machine": (
        "test_viewing_server",
        "test_viewing_connections",
    ),
    "another user of this machine": ("test_private_files",),
    "the clock of this machine": ("test_clocks",),
    "a lossy link": ("test_doctor_delivery",),
    "whatever hangs while a command ends": (
        "test_stopping",
        "test_command_stops",
        "test_interrupts",
    ),
}


def tried_table(root: Path) -> Iterator[str]:
    """Yields the lines of the table.

    Args:
        root: the folder of the checkout.

    Raises:
        OSError: one of the files is missing.
    """
    yield "| by | what holds | tests |"
    yield "|---|---|---|"
    for by, files in _TRIED.items():
        for file in files:
            path = f"{_KOTLIN}/{file}.kt" if "/" in file else f"{_PYTHON}/{file}.py"
            text = (root / path).read_text("utf-8")
            sentences = _of_kotlin(text) if "/" in file else _of_python(text)
            link = f"[{file.rpartition('/')[2]}]({path})"
            yield f"| {by} | {'<br>'.join(sentences)} | {link} |"


def _of_python(text: str) -> Iterator[str]:
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            yield node.name.removeprefix("test_").replace("_", " ")


def _of_kotlin(text: str) -> Iterator[str]:
    for name in re.findall(r"@(?:Parameterized)?Test\b(?:\s*@.*)*\s*fun (\w+)\(", text):
        yield re.sub("([A-Z])", r" \1", name).lower()

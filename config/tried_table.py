"""The table in SECURITY.md of what was tried: the names of tests, as sentences."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

# Who tries, and the files of host_receiver/test that are about it.
_TRIED = {
    "anybody on the network": (
        "test_malicious_peers",
        "test_address_limits",
        "test_pairing_listener",
        "test_secure_server",
    ),
    "a paired headset": ("test_frame", "test_messages", "test_event_limit", "test_printable"),
    "a receiver, to `play`": ("test_play_extremes",),
    "whoever made a file that is read": (
        "test_bag_forms",
        "test_calibration",
        "test_special_files",
    ),
    "another node of the ROS domain": (
        "test_eye_cameras",
        "test_save_config",
        "test_callback_failures",
        "test_viewing_hostile",
    ),
    "a subscriber in ROS or on Zenoh": ("test_demand",),
    "a browser, or a program of this machine": (
        "test_viewing_server",
        "test_viewing_connections",
    ),
    "another user of this machine": ("test_private_files",),
    "the clock of this machine": ("test_clocks",),
    "whatever hangs while a command ends": ("test_stopping", "test_command_stops"),
}


def tried_table(tests: Path) -> Iterator[str]:
    """Yields the lines of the table.

    Args:
        tests: the folder of the files.

    Raises:
        OSError: one of the files is missing.
    """
    yield "| by | what holds | tests |"
    yield "|---|---|---|"
    for by, files in _TRIED.items():
        for file in files:
            path = tests / f"{file}.py"
            link = f"[{file}](host_receiver/test/{file}.py)"
            yield f"| {by} | {'<br>'.join(_sentences(path))} | {link} |"


def _sentences(file: Path) -> Iterator[str]:
    for node in ast.parse(file.read_text("utf-8")).body:
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            yield node.name.removeprefix("test_").replace("_", " ")

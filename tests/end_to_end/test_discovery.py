"""A headset finds a receiver by its name."""

from __future__ import annotations

import contextlib
import os
import re
import time
from pathlib import Path

from configurations import only
from ml2_receiver.transport.discovery import FoundReceiver, find_receivers
from processes import (
    ON_LOOPBACK,
    headset_command,
    isolated_environment,
    line_with,
    listening_address,
    process,
    receive_command,
)
from waiting import LIMIT_S

CONFIG = only("battery: {enabled: true}")


def announced(address: str) -> FoundReceiver:
    """Waits for the announcement of the receiver that listens on `address`."""
    deadline_s = time.monotonic() + LIMIT_S
    while time.monotonic() < deadline_s:
        for receiver in find_receivers(interfaces=["127.0.0.1"]):
            if f"{receiver.addresses[0]}:{receiver.port}" == address:
                return receiver
    raise AssertionError(f"expected an announcement of {address} within {LIMIT_S:g} s, found none")


def connected_from(log: Path) -> bool:
    return re.search(r"connected from 127\.0\.0\.1:", log.read_text()) is not None


def test_a_headset_finds_a_receiver_by_name_also_at_a_new_address(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG)
    # The names are unique, because other users of this machine may run the same test.
    names = {name: f"{name}{os.getpid()}" for name in ("other", "chosen")}
    runs = {
        name: receive_command(config, "127.0.0.1:0", "--name", unique)
        for name, unique in names.items()
    }
    logs = {name: tmp_path / f"{name}.log" for name in ("other", "chosen", "moved", "headset")}
    with contextlib.ExitStack() as stack:
        start = stack.enter_context
        announced(
            listening_address(start(process(runs["other"], isolated_environment(), logs["other"])))
        )
        environment = isolated_environment()
        chosen = start(process(runs["chosen"], environment, logs["chosen"]))
        name = announced(listening_address(chosen)).name
        assert name == names["chosen"]
        command = headset_command(name)
        headset = start(process(command, environment | ON_LOOPBACK, logs["headset"]))
        line_with(headset, "connected to")
        chosen.terminate()
        chosen.wait()
        moved = start(process(runs["chosen"], environment, logs["moved"]))
        assert announced(listening_address(moved)).name == name
        line_with(headset, "connected to")
        assert connected_from(logs["chosen"])
        assert connected_from(logs["moved"])
        assert not connected_from(logs["other"])

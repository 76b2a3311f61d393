"""A headset that knows a receiver's name, and no address."""

from __future__ import annotations

import contextlib
import re
import time
from pathlib import Path

from ml2_receiver.discovery import FoundReceiver, find_receivers
from processes import (
    HEADSET,
    isolated_environment,
    line_with,
    listening_address,
    process,
    receive_command,
)

CONFIG = "/**: {ros__parameters: {battery: {enabled: true}}}\n"
FOUND_S = 10.0
RECONNECT_S = 3.0
# Of the JVM's mDNS library: which network to look on.
ON_LOOPBACK = {"JDK_JAVA_OPTIONS": "-Dnet.mdns.interface=127.0.0.1"}


def announced(address: str) -> FoundReceiver:
    """The announcement of the receiver that listens there; both receivers are called the same."""
    deadline_s = time.monotonic() + FOUND_S
    while time.monotonic() < deadline_s:
        for receiver in find_receivers(0.5, ["127.0.0.1"]):
            if f"{receiver.addresses[0]}:{receiver.port}" == address:
                return receiver
    raise AssertionError(f"nobody announces {address}")


def connected_from(log: Path) -> bool:
    return re.search(r"connected from 127\.0\.0\.1:", log.read_text()) is not None


def test_a_headset_finds_the_receiver_of_a_name_also_when_it_moves(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(CONFIG)
    run = receive_command(config, "127.0.0.1:0")
    logs = {name: tmp_path / f"{name}.log" for name in ("other", "chosen", "moved", "headset")}
    with contextlib.ExitStack() as stack:
        start = stack.enter_context
        announced(listening_address(start(process(run, isolated_environment(), logs["other"]))))
        environment = isolated_environment()
        chosen = start(process(run, environment, logs["chosen"]))
        name = announced(listening_address(chosen)).name
        command: list[str | Path] = [HEADSET, "--receiver", name, "--source", "test-signal"]
        headset = start(process(command, environment | ON_LOOPBACK, logs["headset"]))
        line_with(headset, "connected to")
        chosen.terminate()
        chosen.wait()
        moved = start(process(run, environment, logs["moved"]))
        assert announced(listening_address(moved)).name == name
        announced_s = time.monotonic()
        line_with(headset, "connected to")
        assert time.monotonic() - announced_s < RECONNECT_S
        assert connected_from(logs["chosen"])
        assert connected_from(logs["moved"])
        assert not connected_from(logs["other"])

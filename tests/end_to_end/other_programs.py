"""Runs other programs while a headset streams to a receiver."""

from __future__ import annotations

import contextlib
import json
import pickle
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from processes import (
    PATHS,
    Received,
    ended,
    full_name,
    headset_command,
    isolated_environment,
    listening_address,
    process,
    receive_command,
)


@contextlib.contextmanager
def streaming(config: Path, folder: Path, **simulation: str) -> Iterator[dict[str, str]]:
    """Streams until the end of the block; yields the environment variables."""
    environment = isolated_environment()
    options = [word for it in simulation.items() for word in ("--simulate", "=".join(it))]
    receive = receive_command(config, "127.0.0.1:0")
    with process(receive, environment, folder / "receiver.log") as receiver:
        headset = headset_command(listening_address(receiver), *options)
        with process(headset, environment, folder / "headset.log"):
            yield environment


def collect(
    types: Mapping[str, str], count: int, environment: dict[str, str], folder: Path
) -> Received:
    """Collects at least `count` messages of each topic.

    Args:
        types: message types by topic name, relative to the prefix or absolute.
    """
    names = {full_name(name): type for name, type in types.items()}
    output = folder / "topics.pickle"
    script = Path(__file__).with_name("topics_subscriber.py")
    command: list[str | Path] = [sys.executable, script, json.dumps(names), str(count), output]
    ended(command, environment | PATHS).check_returncode()
    topics = pickle.loads(output.read_bytes())
    output.unlink()
    counts = {name: len(payloads) for name, (_, payloads) in topics.items()}
    assert min(counts.values()) >= count, counts
    return Received({}, {}, topics, [], {}, {}, [])

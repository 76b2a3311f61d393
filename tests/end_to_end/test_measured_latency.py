"""`ml2-receiver latency` beside a running receiver: every stream of the simulated headset."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import pytest

from processes import (
    RECEIVER,
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
    subscribing,
)
from simulation import demo_config

DURATION_S = 3
# A figure has three decimals, and four of them are added up.
ROUNDING_MS = 0.003


@dataclass(frozen=True)
class Row:
    """Of the table, in ms."""

    stream: str
    messages: int
    shares_ms: list[float]
    mean_ms: float
    p50_ms: float
    p99_ms: float
    jitter_ms: float


@dataclass(frozen=True)
class Measured:
    """The rows by topic, and the stream of each topic as an independent subscriber knows it."""

    rows: dict[str, Row]
    streams: dict[str, str]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Measured:
    """With every topic flowing, as the subscriber has seen."""
    folder = tmp_path_factory.mktemp("latency")
    config = folder / "everything.yaml"
    config.write_text(demo_config())
    environment = isolated_environment()
    with ExitStack() as stack:
        start = stack.enter_context
        command = receive_command(config, "127.0.0.1:0", "--start-paused")
        receiver = start(process(command, environment, folder / "receiver.log"))
        subscriber = start(subscribing(environment, folder))
        headset = headset_command(listening_address(receiver), "--duration", "60")
        start(process(headset, environment, folder / "headset.log"))
        topics = flowing(subscriber)
        latency: list[str | Path] = [RECEIVER, "latency", "--once", "--duration", str(DURATION_S)]
        with process(latency, environment, folder / "latency.log") as child:
            rows = dict(table_rows(lines(child)))
            assert child.wait() == 0, (folder / "latency.log").read_text()
    return Measured(rows, topics)


def flowing(subscriber: subprocess.Popen[str]) -> dict[str, str]:
    """The stream of every topic, when something has arrived of each."""
    for line in lines(subscriber):
        topics = json.loads(line)["topics"]
        if topics and all(seen["count"] for seen in topics.values()):
            return {name: seen["stream"] for name, seen in topics.items()}
    raise AssertionError("the subscriber ended before everything had arrived")


def table_rows(said: Iterator[str]) -> Iterator[tuple[str, Row]]:
    stream = ""
    for line in said:
        cells = [cell.strip() for cell in line.split("│")[1:-1]]
        if len(cells) == 11:
            stream = cells[0] or stream
            figures = [float(cell) for cell in cells[3:]]
            yield cells[1], Row(stream, int(cells[2]), figures[:4], *figures[4:])


def test_every_topic_is_there_under_its_stream(measured: Measured) -> None:
    assert {name: row.stream for name, row in measured.rows.items()} == measured.streams
    assert min(row.messages for row in measured.rows.values()) > 0


def test_no_stage_ends_before_it_begins(measured: Measured) -> None:
    for name, row in measured.rows.items():
        sent, received, published, subscriber = row.shares_ms
        assert min(sent, published, subscriber) >= 0, name
        # Two clocks are compared here; on one machine they differ by far less.
        assert received > -1, name


def test_the_shares_add_up_to_the_mean(measured: Measured) -> None:
    for name, row in measured.rows.items():
        assert row.mean_ms == pytest.approx(sum(row.shares_ms), abs=ROUNDING_MS), name
        assert row.p50_ms <= row.p99_ms, name
        assert row.jitter_ms >= 0, name


def test_messages_are_those_of_the_duration(measured: Measured) -> None:
    gyro = measured.rows["/magic_leap2/gyro_left/imu"]
    camera = measured.rows["/magic_leap2/world_left/image_raw"]
    assert gyro.messages / camera.messages == pytest.approx(200 / 30, rel=0.2)

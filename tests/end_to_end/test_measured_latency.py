"""`ml2-receiver latency` measures every stream of the simulated headset."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import links
from counters import await_snapshot, have_arrived
from processes import (
    PREFIX,
    RECEIVER,
    draw_images,
    headset_command,
    isolated_environment,
    lines,
    listening_address,
    process,
    receive_command,
    subscribing,
)
from shaped_link import why_not
from simulation import SMALL, compressed_config, raw_config
from waiting import durations_s

# It measures time.
pytestmark = pytest.mark.alone

# The error of a sum of four values with three decimals.
ROUNDING_MS = 0.003


@dataclass(frozen=True)
class Row:
    """A row of the table, in ms."""

    messages: int
    shares_ms: list[float]
    mean_ms: float
    p50_ms: float
    p99_ms: float
    jitter_ms: float


@dataclass(frozen=True)
class Measured:
    """The rows by topic, and the topics that an independent subscriber found."""

    rows: dict[str, Row]
    topics: set[str]


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Measured:
    """Runs the command after the subscriber has received messages on every topic."""
    folder = tmp_path_factory.mktemp("latency")
    config = folder / "everything.yaml"
    config.write_text(raw_config(picture_center=SMALL))
    draw_images(config, ())
    environment = isolated_environment()
    with ExitStack() as stack:
        start = stack.enter_context
        command = receive_command(config, "127.0.0.1:0", "--start-paused")
        receiver = start(process(command, environment, folder / "receiver.log"))
        subscriber = start(subscribing(environment, folder))
        headset = headset_command(listening_address(receiver))
        start(process(headset, environment, folder / "headset.log"))
        found = await_snapshot(subscriber, have_arrived({}, of_others=1))["topics"]
        topics = {it.removeprefix(f"{PREFIX}/").lstrip("/") for it in found}
        latency: list[str | Path] = [RECEIVER, "latency", "--once", "--duration"]
        for duration_s in durations_s(3):
            command = [*latency, str(duration_s)]
            with process(command, environment, folder / "latency.log") as child:
                rows = dict(table_rows(lines(child)))
                assert child.wait() == 0, (folder / "latency.log").read_text()
            if rows.keys() == topics:
                break
    return Measured(rows, topics)


def table_rows(output: Iterator[str]) -> Iterator[tuple[str, Row]]:
    for line in output:
        topic, *cells = line.split() or [""]
        if len(cells) == 9 and cells[0].isdecimal():
            figures = [float(cell) for cell in cells[1:]]
            yield topic, Row(int(cells[0]), figures[:4], *figures[4:])


def test_every_topic_has_a_row(measured: Measured) -> None:
    assert measured.rows.keys() == measured.topics
    assert min(row.messages for row in measured.rows.values()) > 0


def test_no_stage_ends_before_it_begins(measured: Measured) -> None:
    for name, row in measured.rows.items():
        sent, received, published, subscriber = row.shares_ms
        assert min(sent, published, subscriber) >= 0, name
        # Two clocks are compared; on one machine they differ by far less than 1 ms.
        assert received > -1, name


def test_the_shares_add_up_to_the_mean(measured: Measured) -> None:
    for name, row in measured.rows.items():
        assert row.mean_ms == pytest.approx(sum(row.shares_ms), abs=ROUNDING_MS), name
        assert row.p50_ms <= row.p99_ms, name
        assert row.jitter_ms >= 0, name


def test_a_topic_of_200_hz_has_more_messages_than_one_of_30_hz(measured: Measured) -> None:
    gyro = measured.rows["gyro_left/imu"]
    camera = measured.rows["world_left/image_raw"]
    assert gyro.messages > camera.messages


def measured_until(
    is_enough: Callable[[dict[str, Any]], bool], run: links.Run, shortest_s: float
) -> dict[str, Any]:
    """Measures a link, ever longer on a slow machine, until it has shown enough."""
    for duration_s in durations_s(shortest_s):
        row = links.measure(run, duration_s)
        if is_enough(row):
            break
    return row


def is_filled(row: dict[str, Any]) -> bool:
    return bool(row["sent_mbit"] > 50)


def is_lowered(row: dict[str, Any]) -> bool:
    return any("quality 40" in step for step in row["steps"])


def test_images_that_fill_a_link_delay_no_inertial_sample() -> None:
    if reason := why_not():
        pytest.skip(reason)
    row = measured_until(is_filled, links.Run("raw", 100), 10)
    assert row["imu_lost"] == row["imu_late"], row
    assert is_filled(row), row
    # Half a second where nothing paces the images; the bound leaves room for a busy machine
    assert row["imu_p50_ms"] < 25, row


def test_images_give_way_to_a_slow_link() -> None:
    if reason := why_not():
        pytest.skip(reason)
    row = measured_until(is_lowered, links.Run("auto", 30, config=compressed_config()), 12)
    assert row["imu_lost"] == row["imu_late"], row
    assert is_lowered(row), row
    rates = {name.split("/")[2]: rate_hz for name, rate_hz in row["image_hz"].items()}
    assert 0 < rates["eye_nasal_left"] < rates["world_left"] < 30, row

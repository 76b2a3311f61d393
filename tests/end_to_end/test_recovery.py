"""Links that break or are slow, processes that die: all recover, and the books balance."""

from __future__ import annotations

import itertools
import random
import re
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from books import assert_books_balance
from processes import (
    PREFIX,
    Received,
    headset_command,
    line_with,
    listening_address,
    receive,
    receive_command,
)
from proxy import Proxy
from stage import Stage, staged

GYRO = f"{PREFIX}/gyro_left/imu"
RECOVERY_S = 3.0
# Fast DDS announces participants every 3 s: one that missed the first word waits for the next.
DISCOVERY_S = 3.0


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """One raw camera and everything small."""
    file = tmp_path / "config.yaml"
    file.write_text(
        "/ml2_receiver:\n  ros__parameters:\n"
        "    world_left: {enabled: true}\n    other_sensors: {enabled: true}\n"
    )
    return file


def dropped(received: Received, topic: str, reason: str) -> int:
    return int(received.books(topic).get(f"dropped.{reason}", 0))


def test_a_link_that_is_cut_twice_comes_back(config: Path, tmp_path: Path) -> None:
    def cut(proxy: Proxy | None, snapshot: int) -> None:
        if proxy is not None and snapshot in (1, 4):
            proxy.cut()

    received = receive(config, ["--duration", "8"], tmp_path, Proxy, cut)
    assert_books_balance(received)
    assert dropped(received, GYRO, "link_down") > 0
    assert_arrives_again(received)
    assert {len(ids) for ids in received.publishers.values()} == {1}, "publishers stay"


def test_a_link_that_carries_nothing_for_ten_seconds_comes_back(
    config: Path, tmp_path: Path
) -> None:
    up_s: list[float] = []

    def interrupt(proxy: Proxy | None, snapshot: int) -> None:
        assert proxy is not None
        if snapshot == 1:
            proxy.take_down()
        elif snapshot == 11:
            proxy.bring_up()
            up_s.append(time.monotonic())

    received = receive(config, ["--duration", "16"], tmp_path, Proxy, interrupt)
    assert_books_balance(received)
    assert dropped(received, GYRO, "link_down") > 1000
    assert_arrives_after(up_s[0], received)
    assert {len(ids) for ids in received.publishers.values()} == {1}, "publishers stay"


def assert_arrives_again(received: Received) -> None:
    for topic in (GYRO, f"{PREFIX}/world_left/image_raw"):
        gaps_s = [b - a for a, b in itertools.pairwise(received.arrivals_s[topic])]
        assert max(gaps_s) < RECOVERY_S, topic


@pytest.mark.parametrize("bytes_per_s", [10e6, 1e6])
def test_a_slow_link_drops_images_and_counts_them(
    config: Path, tmp_path: Path, bytes_per_s: float
) -> None:
    """One raw camera is 31 MB/s; the slower link does not even empty the queue at the end."""
    options = ["--duration", "3"]
    received = receive(config, options, tmp_path, lambda address: Proxy(address, bytes_per_s))
    assert_books_balance(received)
    assert dropped(received, f"{PREFIX}/world_left/image_raw", "queue_full") > 20
    assert received.books(GYRO)["gaps"] == str(dropped(received, GYRO, "source_late"))


@pytest.fixture
def stage(config: Path, tmp_path: Path) -> Iterator[Stage]:
    with staged(config, tmp_path) as stage:
        yield stage


def test_a_receiver_that_is_killed_and_restarted_is_found_again(stage: Stage, config: Path) -> None:
    with stage.started("headset", headset_command(stage.address, "--duration", "12")):
        stage.await_seconds(2)
        stage.receiver.kill()
        stage.receiver.wait()
        with stage.started("receiver2", receive_command(config, stage.address)) as second:
            listening_address(second)
            back_s, back_wall_s = time.monotonic(), time.time()
            received = stage.result()
    log = (stage.folder / "receiver2.log").read_text()
    streaming = re.search(r"\[INFO\] \[([\d.]+)\] .*streams: ", log)
    assert streaming is not None, log
    assert float(streaming[1]) - back_wall_s < RECOVERY_S
    assert_arrives_after(back_s, received, RECOVERY_S + DISCOVERY_S)


def test_a_headset_that_is_killed_and_restarted_is_taken_again(stage: Stage) -> None:
    with stage.started("headset1", headset_command(stage.address)) as first:
        stage.await_seconds(2)
        first.kill()
    with stage.started("headset2", headset_command(stage.address, "--duration", "3")) as second:
        line_with(second, "connected to")
        back_s = time.monotonic()
        received = stage.result()
    assert_arrives_after(back_s, received)
    assert {len(ids) for ids in received.publishers.values()} == {1}, "publishers stay"


def test_another_headset_takes_the_place_of_one_that_died(stage: Stage) -> None:
    with stage.started("headset1", headset_command(stage.address)) as first:
        stage.await_seconds(2)
        first.kill()
    command = headset_command(stage.address, "--seed", "2", "--duration", "3")
    with stage.started("headset2", command) as second:
        line_with(second, "connected to")
        back_s = time.monotonic()
        received = stage.result()
    assert_arrives_after(back_s, received)
    assert {len(ids) for ids in received.publishers.values()} == {1}, "publishers stay"


@pytest.mark.parametrize("seed", range(3))
def test_a_headset_may_die_at_any_moment(stage: Stage, seed: int) -> None:
    """The moments are spread over its start, its handshake, and its first messages."""
    moments = random.Random(seed)
    for number in range(3):
        with stage.started(f"killed{number}", headset_command(stage.address)) as killed:
            time.sleep(moments.uniform(0.5, 2.5))
            killed.kill()
    with stage.started("headset", headset_command(stage.address, "--duration", "3")) as last:
        line_with(last, "connected to")
        back_s = time.monotonic()
        received = stage.result()
    assert max(received.arrivals_s[GYRO]) > back_s


def assert_arrives_after(back_s: float, received: Received, limit_s: float = RECOVERY_S) -> None:
    arrivals_s = received.arrivals_s[GYRO]
    assert arrivals_s[0] < back_s
    assert min(at for at in arrivals_s if at > back_s) - back_s < limit_s


def test_a_second_headset_is_refused_and_the_first_goes_on(stage: Stage) -> None:
    with stage.started("headset1", headset_command(stage.address, "--duration", "6")):
        stage.await_seconds(1)
        with stage.started("headset2", headset_command(stage.address, "--seed", "2")) as second:
            assert "busy" in line_with(second, "busy")
            refused_s = time.monotonic()
        received = stage.result()
    assert_books_balance(received)
    assert received.books(GYRO).get("dropped.link_down") is None
    assert max(received.arrivals_s[GYRO]) > refused_s

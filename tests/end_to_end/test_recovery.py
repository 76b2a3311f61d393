"""Links that break or are slow, processes that die: all recover, and the books balance."""

from __future__ import annotations

import itertools
import time
from pathlib import Path

import pytest

from processes import (
    PREFIX,
    Received,
    headset_command,
    isolated_environment,
    line_with,
    lines,
    listening_address,
    process,
    receive,
    receive_command,
    result,
    subscribing,
)
from proxy import Proxy

GYRO = f"{PREFIX}/gyro_left/imu"
RECOVERY_S = 3.0


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """One raw camera and everything small."""
    file = tmp_path / "config.yaml"
    file.write_text(
        "/ml2_receiver:\n  ros__parameters:\n"
        "    world_left: {enabled: true}\n    other_sensors: {enabled: true}\n"
    )
    return file


def assert_books_balance(received: Received) -> None:
    for topic, seen in received.snapshot["topics"].items():
        books = received.books(topic)
        dropped = sum(int(n) for key, n in books.items() if key.startswith("dropped."))
        assert int(books["produced"]) == int(books["received"]) + int(books["gaps"]), topic
        assert int(books["gaps"]) == dropped, topic
        assert 0 < seen["count"] <= int(books["received"]), topic


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


def assert_arrives_again(received: Received) -> None:
    for topic in (GYRO, f"{PREFIX}/world_left/image_raw"):
        gaps_s = [b - a for a, b in itertools.pairwise(received.arrivals_s[topic])]
        assert max(gaps_s) < RECOVERY_S, topic


def test_a_slow_link_drops_images_and_counts_them(config: Path, tmp_path: Path) -> None:
    """One raw camera is 250 Mbit/s; the link has 80."""
    options = ["--duration", "4"]
    received = receive(config, options, tmp_path, lambda address: Proxy(address, 10e6))
    assert_books_balance(received)
    assert dropped(received, f"{PREFIX}/world_left/image_raw", "queue_full") > 20
    assert received.books(GYRO)["gaps"] == str(dropped(received, GYRO, "source_late"))


def test_a_receiver_that_is_killed_and_restarted_is_found_again(
    config: Path, tmp_path: Path
) -> None:
    environment = isolated_environment()
    paused = receive_command(config, "127.0.0.1:0", "--start-paused")
    with (
        process(paused, environment, tmp_path / "receiver1.log") as first,
        subscribing(environment, tmp_path) as subscriber,
    ):
        address = listening_address(first)
        command = headset_command(address, "--duration", "12")
        with process(command, environment, tmp_path / "headset.log"):
            said = lines(subscriber)
            next(said), next(said)
            first.kill()
            first.wait()
            command = receive_command(config, address)
            with process(command, environment, tmp_path / "receiver2.log") as second:
                listening_address(second)
                back_s = time.monotonic()
                for _ in said:
                    pass
                received = result(subscriber, tmp_path)
    arrivals_s = received.arrivals_s[GYRO]
    assert arrivals_s[0] < back_s
    assert min(a for a in arrivals_s if a > back_s) - back_s < RECOVERY_S


def test_a_headset_that_is_killed_and_restarted_is_taken_again(
    config: Path, tmp_path: Path
) -> None:
    environment = isolated_environment()
    paused = receive_command(config, "127.0.0.1:0", "--start-paused")
    with (
        process(paused, environment, tmp_path / "receiver.log") as receiver,
        subscribing(environment, tmp_path) as subscriber,
    ):
        address = listening_address(receiver)
        said = lines(subscriber)
        command = headset_command(address)
        with process(command, environment, tmp_path / "headset1.log") as first:
            next(said), next(said)
            first.kill()
        command = headset_command(address, "--duration", "3")
        with process(command, environment, tmp_path / "headset2.log") as second:
            line_with(second, "connected to")
            back_s = time.monotonic()
            for _ in said:
                pass
            received = result(subscriber, tmp_path)
    arrivals_s = received.arrivals_s[GYRO]
    assert arrivals_s[0] < back_s
    assert min(a for a in arrivals_s if a > back_s) - back_s < RECOVERY_S
    assert {len(ids) for ids in received.publishers.values()} == {1}, "publishers stay"


def test_a_second_headset_is_refused_and_the_first_goes_on(config: Path, tmp_path: Path) -> None:
    environment = isolated_environment()
    paused = receive_command(config, "127.0.0.1:0", "--start-paused")
    with (
        process(paused, environment, tmp_path / "receiver.log") as receiver,
        subscribing(environment, tmp_path) as subscriber,
    ):
        address = listening_address(receiver)
        command = headset_command(address, "--duration", "6")
        with process(command, environment, tmp_path / "headset1.log"):
            said = lines(subscriber)
            next(said)
            command = headset_command(address, "--seed", "2")
            with process(command, environment, tmp_path / "headset2.log") as second:
                assert "busy" in line_with(second, "busy")
                refused_s = time.monotonic()
            for _ in said:
                pass
            received = result(subscriber, tmp_path)
    assert_books_balance(received)
    assert received.books(GYRO).get("dropped.link_down") is None
    assert max(received.arrivals_s[GYRO]) > refused_s

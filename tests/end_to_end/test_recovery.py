"""Sessions recover from broken links, slow links and killed processes, and counters agree."""

from __future__ import annotations

import random
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from capture_stamps import stamp_ns
from configurations import only
from counters import Snapshot, assert_counters_agree
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
from simulation import STILL
from waiting_receiver import WaitingReceiver, waiting_receiver

CONFIG = only("eye_nasal_left: {enabled: true}, other_sensors: {enabled: true}")
GYRO = f"{PREFIX}/gyro_left/imu"
IMAGE = f"{PREFIX}/eye_nasal_left/image_raw"
# Messages that were in flight when a link broke have arrived after this time.
IN_FLIGHT_S = 0.5


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """A configuration with a small raw camera and all small streams."""
    file = tmp_path / "config.yaml"
    file.write_text(CONFIG)
    return file


def dropped(received: Received, topic: str, reason: str) -> int:
    return int(received.counters(topic).get(f"dropped.{reason}", 0))


@pytest.fixture
def waiting(config: Path, tmp_path: Path) -> Iterator[WaitingReceiver]:
    with waiting_receiver(config, tmp_path) as waiting:
        yield waiting


@contextmanager
def streaming(waiting: WaitingReceiver) -> Iterator[tuple[Proxy, subprocess.Popen[str]]]:
    """Runs a headset behind a proxy, until readings arrive and longer."""
    with (
        Proxy(waiting.address) as proxy,
        waiting.started("headset", headset_command(proxy.address)) as headset,
    ):
        waiting.await_reading(after_s=time.time())
        yield proxy, headset


def await_all(waiting: WaitingReceiver) -> None:
    """Waits for an image and a reading that were not in flight before."""
    begin_s = time.time() + IN_FLIGHT_S
    waiting.await_snapshot(
        lambda it: all(it["topics"][topic]["last_s"] > begin_s for topic in (GYRO, IMAGE))
    )


def test_a_link_that_is_cut_twice_comes_back(waiting: WaitingReceiver) -> None:
    with streaming(waiting) as (proxy, headset):
        for _ in range(2):
            proxy.cut()
            await_all(waiting)
        headset.terminate()
        received = waiting.result()
    assert_counters_agree(received)
    assert dropped(received, GYRO, "link_down") > 0
    assert {len(ids) for ids in received.publishers.values()} == {1}, "publishers stay"


def test_a_link_that_carries_nothing_for_ten_seconds_comes_back(waiting: WaitingReceiver) -> None:
    with streaming(waiting) as (proxy, headset):
        proxy.take_down()
        waiting.await_seconds(10)
        proxy.bring_up()
        await_all(waiting)
        headset.terminate()
        received = waiting.result()
    assert_counters_agree(received)
    assert dropped(received, GYRO, "link_down") > 0
    stamps_ns = [stamp_ns(it) for it in received.messages(GYRO)]
    assert np.diff(stamps_ns).max() > 5e9, "what nobody could take is not kept"
    assert {len(ids) for ids in received.publishers.values()} == {1}, "publishers stay"


@pytest.mark.parametrize("bytes_per_s", [10e6, 1e6])
def test_a_slow_link_drops_images_and_counts_them(
    config: Path, tmp_path: Path, bytes_per_s: float
) -> None:
    """A world camera is 31 MB/s; at 1 MB/s, the queue is not even empty at the end."""
    fixed = CONFIG.replace("eye_nasal_left", "world_left") + "    general: {link: fixed}\n"
    config.write_text(fixed)
    image = f"{PREFIX}/world_left/image_raw"

    def has_dropped(snapshot: Snapshot) -> bool:
        return int(snapshot["topics"][image]["diagnostics"].get("dropped.queue_full", 0)) > 20

    def link(address: str) -> Proxy:
        return Proxy(address, bytes_per_s)

    received = receive(config, [*STILL], tmp_path, link, is_enough=has_dropped)
    assert_counters_agree(received)
    assert dropped(received, image, "queue_full") > 20
    assert dropped(received, GYRO, "queue_full") == 0


def test_a_receiver_that_is_killed_and_restarted_is_found_again(
    waiting: WaitingReceiver, config: Path
) -> None:
    with waiting.started("headset", headset_command(waiting.address)) as headset:
        waiting.await_seconds(1)
        waiting.receiver.kill()
        waiting.receiver.wait()
        with waiting.started("receiver2", receive_command(config, waiting.address)) as second:
            listening_address(second)
            back_s = time.monotonic()
            waiting.await_reading(after_s=time.time())
            headset.terminate()
            received = waiting.result()
    assert received.arrivals_s[GYRO][-1] > back_s


@pytest.mark.parametrize("seed", [1, 2], ids=["the same", "another"])
def test_a_headset_takes_the_place_of_those_that_were_killed_at_any_moment(
    waiting: WaitingReceiver, seed: int
) -> None:
    """Two die at random times of start, handshake and first messages, one while it streams."""
    moments = random.Random(seed)
    killed = headset_command(waiting.address, "--seed", "1")
    for number in range(2):
        with waiting.started(f"killed{number}", killed) as early:
            time.sleep(moments.uniform(0.5, 2.5))
            early.kill()
    with waiting.started("streaming", killed) as streaming:
        waiting.await_reading(after_s=time.time())
        streaming.kill()
    with waiting.started("last", headset_command(waiting.address, "--seed", str(seed))) as last:
        line_with(last, "connected to")
        back_s = time.monotonic()
        waiting.await_reading(after_s=time.time())
        last.terminate()
        received = waiting.result()
    assert received.arrivals_s[GYRO][-1] > back_s
    assert {len(ids) for ids in received.publishers.values()} == {1}, "publishers stay"


def test_a_second_headset_is_refused_and_the_first_goes_on(waiting: WaitingReceiver) -> None:
    with waiting.started("headset1", headset_command(waiting.address)) as first:
        waiting.await_reading(after_s=0.0)
        with waiting.started("headset2", headset_command(waiting.address, "--seed", "2")) as second:
            assert "busy" in line_with(second, "busy")
            waiting.await_reading(after_s=time.time())
        first.terminate()
        received = waiting.result()
    assert_counters_agree(received)
    assert received.counters(GYRO).get("dropped.link_down") is None

"""Recordings on a disk that is full, fails, is slow, or whose folder is removed."""

import errno
import os
import resource
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import NoReturn

import pytest
import yaml
from mcap.reader import make_reader

import bag_scene
from bag_readers import READERS, digest, mcap_file
from ml2_receiver.errors import PublishError
from ml2_receiver.recording.bag_topic import BagTopic
from ml2_receiver.recording.bag_writer import BagWriter
from ml2_receiver.recording.recorder import Recorder
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Qos
from ml2_tools.bags.bag_reader import Bag
from waiting import LIMIT_S, await_true

BATTERY = load_table().streams["battery"].topics[0]
BATTERIES = BagTopic("/battery", BATTERY.type, Qos(10))


def make_writer(folder: Path, flushed: int) -> BagWriter:
    """Returns a writer with so many chunks of one message each, and an unflushed next one."""
    writer = bag_scene.new_writer(folder, BATTERIES)
    for number in range(flushed):
        writer.write(BATTERIES, number, bag_scene.battery(number))
        writer.flush()
    for number in range(flushed, flushed + 6):  # more than a chunk
        writer.write(BATTERIES, number, bytes(1 << 20))
    assert mcap_file(folder).stat().st_size > writer.flushed_bytes
    return writer


@contextmanager
def file_limit(size: int) -> Iterator[None]:
    """Limits the size of files, which acts as a full disk does."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def check_whole(folder: Path, count: int) -> None:
    """Every reader that goes by the index finds so many messages, and metadata.yaml has them."""
    expected = [digest(bag_scene.battery(number)) for number in range(count)]
    for read in READERS:
        assert [seen.sha256 for seen in read(folder)] == expected
    metadata = yaml.safe_load((folder / "metadata.yaml").read_text())
    assert metadata["rosbag2_bagfile_information"]["message_count"] == count
    with mcap_file(folder).open("rb") as file:
        summary = make_reader(file, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.channel_message_counts == ({1: count} if count else {})


def test_an_abandoned_recording_has_what_was_flushed_and_an_index(tmp_path: Path) -> None:
    writer = make_writer(tmp_path / "walk", 3)
    writer.abandon()
    check_whole(tmp_path / "walk", 3)
    assert mcap_file(tmp_path / "walk").stat().st_size == writer.flushed_bytes


@pytest.mark.parametrize("spare_bytes", [0, 100, 10_000])
def test_what_the_index_needs_on_a_full_disk_is_taken_from_the_last_chunks(
    tmp_path: Path, spare_bytes: int
) -> None:
    writer = make_writer(tmp_path / "walk", 30)
    with file_limit(writer.flushed_bytes + spare_bytes):
        writer.abandon()
    kept = writer.metadata.message_counts()[BATTERIES]
    assert kept == 30 if spare_bytes == 10_000 else 0 < kept < 30
    check_whole(tmp_path / "walk", kept)


def test_a_disk_that_fails_keeps_what_was_flushed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> NoReturn:
        raise OSError(errno.EIO, "input/output error")

    folder = tmp_path / "walk"
    writer = make_writer(folder, 3)
    monkeypatch.setattr(os, "pwrite", fail)
    writer.abandon()
    assert mcap_file(folder).stat().st_size == writer.flushed_bytes
    assert len(list(Bag(folder).messages())) == 3


def test_a_recording_whose_folder_is_removed_says_so(tmp_path: Path) -> None:
    failures: SimpleQueue[str] = SimpleQueue()
    writer = bag_scene.new_writer(tmp_path / "walk")
    recorder = Recorder(writer, load_table(), bag_scene.PREFIX, failures.put)
    publish = recorder.open(BATTERY)
    publish(bytearray(bag_scene.battery(1)))
    bag_scene.remove(tmp_path / "walk")
    assert failures.get(timeout=LIMIT_S) == "somebody has removed its file"
    with pytest.raises(PublishError, match="removed"):
        publish(bytearray(bag_scene.battery(2)))
    recorder.close()
    assert recorder.progress.messages + sum(recorder.progress.dropped.values()) == 2


class Clock:
    """Monotonic time that a test sets."""

    now_s = 0.0

    def monotonic(self) -> float:
        return self.now_s

    time_ns = staticmethod(time.time_ns)


def test_what_came_is_on_the_disk_half_a_second_later(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = Clock()
    monkeypatch.setattr("ml2_receiver.recording.recorder.time", clock)
    writer = bag_scene.new_writer(tmp_path / "walk")
    recorder = Recorder(writer, load_table(), bag_scene.PREFIX, pytest.fail)
    recorder.open(BATTERY)(bytearray(bag_scene.battery(0)))
    await_true(lambda: recorder.progress.messages == 1)
    clock.now_s = 0.5
    await_true(lambda: is_written(tmp_path / "walk", 0))
    recorder.close()


def is_written(folder: Path, number: int) -> bool:
    return bytes(bag_scene.battery(number)) in mcap_file(folder).read_bytes()


def test_messages_are_written_while_the_metadata_wait_for_the_disk(tmp_path: Path) -> None:
    writer = bag_scene.new_writer(tmp_path / "walk")
    recorder = Recorder(writer, load_table(), bag_scene.PREFIX, pytest.fail)
    draft = tmp_path / "walk" / "metadata.yaml.draft"
    os.mkfifo(draft)  # who writes to it waits for who reads
    publish = recorder.open(BATTERY)  # from now on the metadata have to be written

    for number in range(3):
        publish(bytearray(bag_scene.battery(number)))
        await_true(partial(is_written, tmp_path / "walk", number))
    reader = os.open(draft, os.O_RDONLY | os.O_NONBLOCK)
    recorder.close()
    os.close(reader)
    assert recorder.progress.messages == 3

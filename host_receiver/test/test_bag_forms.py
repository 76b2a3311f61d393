"""Recordings as other programs, splits and repairs leave them; each holds the same messages."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
import yaml
from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer

from bag_scene import PREFIX
from ml2_receiver.errors import RecordingError
from ml2_receiver.topics.string_message import encode_string
from ml2_tools.bags.bag_reader import Bag, BagReader
from ml2_tools.bags.indexed_bag import IndexedBag
from refusals import refusal

type Row = tuple[str, str, str, int, bytes]
_STRING = "std_msgs/msg/String"


def rows(folder: Path) -> list[Row]:
    """Topic, type, encoding, time and payload of each message, as the mcap library reads them."""
    found: list[Row] = []
    for file in sorted(folder.glob("*.mcap")):
        with file.open("rb") as stream:
            for schema, channel, message in make_reader(stream).iter_messages(log_time_order=False):
                assert schema is not None
                time_ns = message.log_time
                row = (channel.topic, schema.name, channel.message_encoding, time_ns, message.data)
                found.append(row)
    return found


def write(file: Path, messages: Sequence[Row], **options: Any) -> None:
    file.parent.mkdir(exist_ok=True)
    writer = Writer(str(file), **options)
    writer.start()
    channels: dict[str, int] = {}
    for topic, type, encoding, time_ns, payload in messages:
        if topic not in channels:
            schema = writer.register_schema(type, "ros2msg", b"")
            channels[topic] = writer.register_channel(topic, encoding, schema)
        writer.add_message(channels[topic], time_ns, payload, time_ns)
    writer.finish()


def split(folder: Path, messages: Sequence[Row], *names: str) -> None:
    size = -(-len(messages) // len(names))
    for number, name in enumerate(names):
        write(folder / name, messages[number * size : (number + 1) * size])


FORMS: dict[str, Callable[[Path, list[Row]], None]] = {
    "zstd": lambda folder, it: write(folder / "a.mcap", it, compression=CompressionType.ZSTD),
    "lz4": lambda folder, it: write(folder / "a.mcap", it, compression=CompressionType.LZ4),
    "none": lambda folder, it: write(folder / "a.mcap", it, compression=CompressionType.NONE),
    "no chunks": lambda folder, it: write(folder / "a.mcap", it, use_chunking=False),
    "one chunk": lambda folder, it: write(folder / "a.mcap", it, chunk_size=1 << 30),
    "no repeated channels": lambda folder, it: write(
        folder / "a b.mcap", it, repeat_channels=False
    ),
    "no repeated schemas": lambda folder, it: write(folder / "a.mcap", it, repeat_schemas=False),
    "no statistics": lambda folder, it: write(folder / "a.mcap", it, use_statistics=False),
    "no summary offsets": lambda folder, it: write(
        folder / "a.mcap", it, use_summary_offsets=False
    ),
    "no index": lambda folder, it: write(folder / "a.mcap", it, index_types=IndexType.NONE),
    "names with dates": lambda folder, it: split(
        folder, it, "walk_2026-11-26-10-59-30.mcap", "walk_2026-11-26-11-00-00.mcap"
    ),
    "names against the order": lambda folder, it: split(folder, it, "z.mcap", "y.mcap", "x.mcap"),
}


@pytest.fixture(scope="module")
def messages(bag: Path) -> list[Row]:
    found = rows(bag)
    assert len(found) > 20
    return found


@pytest.mark.parametrize("form", FORMS)
def test_every_reader_finds_every_message(form: str, messages: list[Row], tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    FORMS[form](folder, messages)
    read = [(it.topic, it.time_ns, it.payload) for it in Bag(folder).messages()]
    assert read == [(topic, time_ns, payload) for topic, _, _, time_ns, payload in messages]
    assert BagReader(folder).prefix == PREFIX
    indexed = IndexedBag(folder)
    assert sorted(it.time_ns for it in indexed.after(0)) == sorted(it[3] for it in messages)
    assert indexed.counts == Counter(it[0] for it in messages)
    assert not indexed.left_out


def test_the_files_are_those_that_the_metadata_name(
    messages: list[Row], bag: Path, tmp_path: Path
) -> None:
    """A recovered file may lie beside them."""
    folder = tmp_path / "walk"
    shutil.copytree(bag, folder)
    (file,) = folder.glob("*.mcap")
    shutil.copy(file, folder / "recovered.mcap")
    assert sum(1 for _ in Bag(folder).messages()) == len(messages)
    assert Bag(folder).left_out == ["recovered.mcap, which metadata.yaml does not name"]


@pytest.mark.parametrize(
    ("files", "mode", "said"),
    [
        (["gone.mcap"], "", "names gone.mcap, which is not there"),
        (["a.db3"], "", "not supported: a.db3 is in rosbag2's SQLite format"),
        (["a.mcap.zstd"], "FILE", "not supported: a.mcap.zstd is compressed as a whole"),
        (["a.mcap"], "MESSAGE", "not supported: {folder} has messages compressed one by one"),
        (7, "", "names no files"),
    ],
)
def test_metadata_of_what_is_not_read_say_why(
    messages: list[Row], tmp_path: Path, files: object, mode: str, said: str
) -> None:
    write(tmp_path / "a.mcap", messages)
    information = {"relative_file_paths": files, "compression_mode": mode}
    (tmp_path / "metadata.yaml").write_text(
        yaml.safe_dump({"rosbag2_bagfile_information": information})
    )
    for command in ("play", "inspect"):
        assert said.format(folder=tmp_path) in refusal(command, tmp_path)


def test_the_headset_is_found_by_what_its_topic_says(messages: list[Row], tmp_path: Path) -> None:
    hello = encode_string("hello")
    others = [
        (name, _STRING, "cdr", messages[0][3], hello) for name in ("/slam/config", "/x/app/config")
    ]
    own = next(it for it in messages if it[0] == f"{PREFIX}/config")
    copied = (f"{PREFIX}/custom/config", *own[1:])
    write(tmp_path / "a.mcap", [*others, copied, *messages])
    assert BagReader(tmp_path).prefix == PREFIX


def test_of_several_headsets_none_is_chosen_in_silence(messages: list[Row], tmp_path: Path) -> None:
    second = [(f"/robot2{topic}", *rest) for topic, *rest in messages]
    write(tmp_path / "a.mcap", [*messages, *second])  # type: ignore[list-item]
    with pytest.raises(RecordingError, match=f"several headsets: {PREFIX}, /robot2{PREFIX}"):
        BagReader(tmp_path)


def test_an_unknown_compression_is_not_called_damage(messages: list[Row], tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    write(file, messages, compression=CompressionType.LZ4, index_types=IndexType.NONE)
    file.write_bytes(file.read_bytes().replace(b"\x03\x00\x00\x00lz4", b"\x03\x00\x00\x00xyz"))
    with pytest.raises(RecordingError, match="not supported: chunks compressed with 'xyz'"):
        list(Bag(file).messages())

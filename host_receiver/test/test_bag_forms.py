"""Tests which files and messages belong to a recording, and what is said of all others."""

import os
import random
import struct
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from itertools import cycle
from pathlib import Path

import pytest
import yaml
import zstandard
from mcap.writer import CompressionType, IndexType
from mcap_ros2.writer import Writer
from rosbags.rosbag2 import CompressionMode

from bag_forms import STRING, Mcap, Row, Rows, sound_rows, split, text, with_rosbags, write
from command_line import refusal
from ml2_receiver.cli import main
from ml2_receiver.errors import RecordingError
from ml2_receiver.recording.message_definitions import DEFINITIONS
from ml2_tools.bags import bag_reader, mcap_file
from ml2_tools.bags.bag_reader import Bag, BagReader
from ml2_tools.bags.decoding import decoder
from ml2_tools.bags.indexed_bag import History, IndexedBag
from ros_messages import TYPES
from sound_bag import BEGIN_NS, IMU, PREFIX

ROWS = sound_rows()
FIELD = Path(__file__).parents[3] / "shared/data/field/bags"
FIELD_NAMES = sorted(it.name for it in FIELD.iterdir()) if FIELD.exists() else []
MAGIC = b"\x89MCAP0\r\n"


def read(path: Path) -> tuple[int, list[str]]:
    """The number of messages, and what is left out."""
    bag = Bag(path)
    return sum(1 for _ in bag.messages()), bag.left_out


@pytest.mark.parametrize("name", ["made", *FIELD_NAMES])
def test_recordings_of_the_tests_and_from_the_field_are_whole(name: str, tmp_path: Path) -> None:
    folder, expected = FIELD / name, 1541
    if name == "made":
        folder, expected = tmp_path / name, len(ROWS)
        with_rosbags(folder, ROWS)
    bag = IndexedBag(folder)
    # The app has topics of its own.
    others = sum(count for topic, count in bag.counts.items() if "/custom/" in topic)
    assert bag.prefix == PREFIX
    assert sum(1 for _ in bag.messages()) - others == bag.counts.total() - others == expected
    assert not bag.left_out


def test_the_files_are_those_that_the_metadata_name_once_each(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", ROWS)
    write(tmp_path / "b.mcap", ROWS)
    _metadata(tmp_path, ["walk/a.mcap", "a.mcap"])
    assert read(tmp_path) == (len(ROWS), ["b.mcap, which metadata.yaml does not name"])


def test_files_in_folders_of_their_own_are_told_apart(tmp_path: Path) -> None:
    half = len(ROWS) // 2
    write(tmp_path / "one/a.mcap", ROWS[:half])
    write(tmp_path / "other/a.mcap", ROWS[half:])
    _metadata(tmp_path, ["one/a.mcap", "other/a.mcap"])
    assert read(tmp_path) == (len(ROWS), [])


@pytest.mark.parametrize(
    ("files", "mode", "said"),
    [
        (["gone.mcap"], "", "names gone.mcap, which is not there"),
        (["a.db3"], "", "not supported: a.db3 is in rosbag2's SQLite format"),
        (["b.mcap.zstd"], "FILE", "not supported: b.mcap.zstd is compressed as a whole"),
        (["a.mcap"], "MESSAGE", "not supported: {folder} has messages compressed one by one"),
        (7, "", "names no files: expected rosbag2_bagfile_information with a list"),
    ],
)
def test_metadata_of_what_is_not_read_say_why(
    tmp_path: Path, files: object, mode: str, said: str
) -> None:
    write(tmp_path / "a.mcap", ROWS)
    _metadata(tmp_path, files, mode)
    for command in ("play", "inspect"):
        assert said.format(folder=tmp_path) in refusal(command, tmp_path)


@pytest.mark.parametrize("has_metadata", [True, False])
@pytest.mark.parametrize("is_packed_there", [True, False])
def test_what_was_unpacked_is_read_for_its_packed_file(
    tmp_path: Path, has_metadata: bool, is_packed_there: bool
) -> None:
    write(tmp_path / "a.mcap", ROWS)
    if is_packed_there:
        (tmp_path / "a.mcap.zstd").write_bytes(zstandard.compress(b"packed"))
    if has_metadata:
        _metadata(tmp_path, ["a.mcap.zstd"], "FILE")
    assert read(tmp_path) == (len(ROWS), [])


ALIASES = """
a: &a {x: 1}
b: &b {<<: [*a, *a, *a, *a, *a, *a, *a, *a, *a]}
rosbag2_bagfile_information: {relative_file_paths: [a.mcap], compression_mode: [*b, *b]}
"""


def test_metadata_with_aliases_are_refused(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", ROWS)
    (tmp_path / "metadata.yaml").write_text(ALIASES)
    with pytest.raises(RecordingError, match="names no files: found an alias"):
        read(tmp_path)


def test_metadata_have_a_bounded_size(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", ROWS)
    with (tmp_path / "metadata.yaml").open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(RecordingError, match="names no files: expected at most"):
        read(tmp_path)


@pytest.mark.parametrize("name", ["metadata.yaml", "a.mcap"])
def test_a_pipe_in_a_recording_is_refused_at_once(tmp_path: Path, name: str) -> None:
    os.mkfifo(tmp_path / name)
    with pytest.raises(RecordingError, match=f"cannot read .*{name}: expected a regular file"):
        read(tmp_path)


def _metadata(folder: Path, files: object, mode: str = "") -> None:
    information = {"relative_file_paths": files, "compression_mode": mode}
    document = yaml.safe_dump({"rosbag2_bagfile_information": information})
    (folder / "metadata.yaml").write_text(document)


def test_files_with_a_pause_between_may_be_two_recordings_and_that_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    later_ns = 2 * 3600 * 10**9 + ROWS[-1].time_ns - ROWS[0].time_ns
    write(tmp_path / "b.mcap", ROWS)
    write(tmp_path / "a.mcap", [replace(it, time_ns=it.time_ns + later_ns) for it in ROWS])
    main(["inspect", str(tmp_path)])
    said = "a.mcap begins 2:00:00 h after b.mcap ends; name one of them if they are two recordings"
    assert capsys.readouterr().err.startswith(f"note: {said}\n")
    assert read(tmp_path) == (2 * len(ROWS), [])
    _metadata(tmp_path, ["b.mcap", "a.mcap"])
    assert not Bag(tmp_path).apart


@pytest.mark.parametrize("of", [slice(None), slice(400, None), slice(400), slice(100, 500)])
def test_a_copy_is_found_out_by_its_messages_and_counted(tmp_path: Path, of: slice) -> None:
    write(tmp_path / "walk.mcap", ROWS)
    write(tmp_path / "a recovered one.mcap", ROWS[of], use_chunking=False)
    copies = len(ROWS[of])
    assert read(tmp_path) == (len(ROWS), [f"{copies} messages that another file has, too"])


@pytest.mark.parametrize("lag_ns", [-900_000_000, -1, 3_000_000, 2_000_000_000])
def test_messages_of_two_recorders_come_once_whatever_their_times(
    tmp_path: Path, lag_ns: int
) -> None:
    jitter = cycle([0, 5_000_000, 1_000_000])
    later = [replace(it, time_ns=it.time_ns + lag_ns + next(jitter)) for it in ROWS]
    write(tmp_path / "a.mcap", ROWS)
    write(tmp_path / "b.mcap", sorted(later, key=lambda it: it.time_ns))
    assert read(tmp_path) == (len(ROWS), [f"{len(ROWS)} messages that another file has, too"])
    middle_ns = (ROWS[0].time_ns + ROWS[-1].time_ns) // 2
    bag = IndexedBag(tmp_path)
    firsts = [min(row.time_ns, copy.time_ns) for row, copy in zip(ROWS, later, strict=True)]
    assert len(list(bag.after(middle_ns))) == sum(first_ns > middle_ns for first_ns in firsts)
    newest = bag.until(middle_ns, {IMU: History(10, None)})
    assert len({it.payload for it in newest}) == len(newest) == 10


def test_equal_messages_of_two_recorders_are_as_many_as_one_had(tmp_path: Path) -> None:
    """A topic without stamps that always says the same, and recorders that overlap for a second."""
    said = [text("/said", "a", at * 100_000_000) for at in range(100)]
    write(tmp_path / "a.mcap", said[:60])
    late = [replace(it, time_ns=it.time_ns + 7_000_000) for it in said[50:]]
    write(tmp_path / "b.mcap", late)
    assert [it.topic for it in Bag(tmp_path).messages()] == ["/said"] * len(said)


def test_times_that_ros_does_not_have_are_not_supported(tmp_path: Path) -> None:
    rows = [replace(it, time_ns=it.time_ns + (1 << 63)) for it in ROWS[:500]]
    write(tmp_path / "a.mcap", rows)
    for command in ("inspect", "play", "export --kalibr k --bag"):
        words = command.split()
        said = refusal(*words, str(tmp_path))
        assert "the last time of ROS is 9223372036854775807 ns" in said


def test_equal_messages_of_one_file_are_no_copies(tmp_path: Path) -> None:
    rows = [it for it in ROWS[:1000] for _ in range(2)]
    split(tmp_path, rows, "a.mcap", "b.mcap")
    assert read(tmp_path) == (len(rows), [])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is empty: it has 0 B"),
        (bytes(5000), "is broken: not a valid MCAP file, it begins with zeros"),
        (b"no recording at all", "not a valid MCAP file, it begins with b'no recor'"),
        (b"SQLite format 3\0", "not supported: a.mcap is in rosbag2's SQLite format"),
        (b"#ROSBAG V2.0\n", "not supported: a.mcap is a recording of ROS 1"),
        (zstandard.compress(MAGIC), "not supported: a.mcap is compressed as a whole"),
    ],
)
@pytest.mark.parametrize("is_named", [True, False])
def test_what_is_no_mcap_is_refused_with_the_reason(
    tmp_path: Path, content: bytes, said: str, is_named: bool
) -> None:
    file = tmp_path / "a.mcap"
    file.write_bytes(content)
    path = file if is_named else tmp_path
    for command in (
        ("play", path),
        ("inspect", path),
        ("export", "--kalibr", tmp_path / "out", "--bag", path),
        ("evaluate", "--camera", "world_left", "--bag", path),
        ("view", "--no-browser", path),
    ):
        assert said in refusal(*command)


def test_another_format_beside_it_is_said(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", ROWS)
    (tmp_path / "b.db3").touch()
    count, (said,) = read(tmp_path)
    assert count == len(ROWS)
    assert "b.db3 is in rosbag2's SQLite format" in said


def test_other_encodings_are_left_out_and_counted(tmp_path: Path) -> None:
    others = [text(f"{PREFIX}/custom/notes", "{}", n, encoding="json") for n in range(3)]
    others += [text("/old", "", n, encoding="ros1") for n in range(2)]
    write(tmp_path / "a.mcap", [*ROWS, *others])
    assert read(tmp_path) == (
        len(ROWS),
        [
            f"3 messages of {PREFIX}/custom/notes, which are 'json', expected 'cdr'",
            "2 messages of /old, which are 'ros1', expected 'cdr'",
        ],
    )


def test_other_encodings_alone_are_not_supported(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", [text("/a", "{}", encoding="protobuf")])
    assert "not supported" in refusal("inspect", tmp_path)
    assert "/a (std_msgs/msg/String) as 'protobuf', expected 'cdr'" in refusal("play", tmp_path)


def test_of_a_topic_with_two_types_the_one_with_fewer_messages_is_said(tmp_path: Path) -> None:
    others = [Row(IMU, STRING, BEGIN_NS + n, text("", "x").payload) for n in range(4)]
    write(tmp_path / "a.mcap", [*others, *ROWS])
    assert read(tmp_path) == (
        len(ROWS),
        [f"4 messages of {IMU} of type {STRING}; most are sensor_msgs/msg/Imu"],
    )


def test_messages_without_their_channel_are_counted(tmp_path: Path) -> None:
    """As in the rest of a file whose beginning is lost."""
    file = tmp_path / "a.mcap"
    mcap = Mcap(file)
    mcap.add(ROWS[:3])
    mcap.flush()
    begin = file.stat().st_size
    mcap.add(ROWS[3:])
    mcap.flush()
    mcap.close(is_finished=False)
    data = file.read_bytes()
    first = data.index(b"\x06")  # the opcode of the first chunk
    file.write_bytes(data[:first] + data[begin:])
    unknown = {it.topic for it in ROWS[:3]}
    lost = sum(it.topic in unknown for it in ROWS[3:])
    assert 0 < lost < len(ROWS) - 3
    assert read(file) == (
        len(ROWS) - 3 - lost,
        [f"{lost} messages whose topic no record tells"],
    )


def test_the_rest_of_a_truncated_file_is_said(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    mcap = Mcap(file, compression=CompressionType.NONE)
    mcap.add(ROWS[:500])
    mcap.flush()
    whole = file.stat().st_size
    mcap.add(ROWS[500:])
    mcap.flush()
    mcap.close(is_finished=False)
    file.write_bytes(file.read_bytes()[: whole + 100])
    assert read(file) == (500, ["100 B at the end of a.mcap, which are no whole message"])


def test_a_length_that_leads_beyond_the_end_of_a_whole_file_is_damage(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    write(file, ROWS, index_types=IndexType.NONE)
    data = bytearray(file.read_bytes())
    struct.pack_into("<Q", data, data.index(b"\x06") + 1, 100 << 20)
    file.write_bytes(data)
    with pytest.raises(RecordingError, match="is broken: it ends within a record"):
        Bag(file)


def test_what_follows_the_end_of_a_recording_is_said(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", ROWS)
    data = (tmp_path / "a.mcap").read_bytes()
    (tmp_path / "a.mcap").write_bytes(data + data)
    assert read(tmp_path) == (
        len(ROWS),
        [f"{len(data)} B at the end of a.mcap, which are no whole message"],
    )


@pytest.mark.parametrize("of", ["chunk", "message"])
def test_what_is_too_large_is_not_supported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, of: str
) -> None:
    large = [Row("/a", STRING, BEGIN_NS, bytes([0, 1, *bytes(4998)]))]
    none = CompressionType.NONE
    write(tmp_path / "a.mcap", large, compression=none, use_chunking=of == "chunk")
    monkeypatch.setattr(mcap_file, "MAX_RECORD_BYTES", 4000)
    with pytest.raises(RecordingError, match=rf"not supported: .* {of} of 5\d* B, at most 4000"):
        list(Bag(tmp_path).messages())


@pytest.mark.parametrize(
    "write_differently",
    [
        lambda folder: write(folder / "WALK_0.MCAP", ROWS),
        lambda folder: write(folder / "a.mcap", [_short(it) for it in ROWS]),
        lambda folder: write(folder / "a.mcap", [_short(it) for it in ROWS], use_chunking=False),
        lambda folder: write(folder / "a.mcap", [_headed(it, b"\0\1\0\3") for it in ROWS]),
        lambda folder: _with_mcap_ros2(folder / "a.mcap", ROWS),
    ],
)
def test_what_other_programs_write_differently_is_the_same(
    tmp_path: Path, write_differently: Callable[[Path], None]
) -> None:
    write_differently(tmp_path)
    bag = Bag(tmp_path)
    found = [Row(it.topic, bag.types[it.topic], it.time_ns, it.payload) for it in bag.messages()]
    assert found == ROWS
    assert not bag.left_out


def _headed(row: Row, header: bytes) -> Row:
    return replace(row, payload=header + row.payload[len(header) :])


def _short(row: Row) -> Row:
    """With the name of its type as the examples of mcap_ros2 write it."""
    return replace(row, type=row.type.replace("/msg/", "/"))


def _with_mcap_ros2(file: Path, rows: Rows) -> None:
    with file.open("wb") as stream, Writer(stream) as writer:
        schemas = {
            type: writer.register_msgdef(type.replace("/msg/", "/"), DEFINITIONS[type])
            for type in sorted({it.type for it in rows})
        }
        for it in rows:
            message = decoder(it.type)(it.payload)
            writer.write_message(it.topic, schemas[it.type], message, it.time_ns)


@pytest.mark.parametrize("ending", ["mcap", "db3"])
def test_a_hidden_file_is_no_part_of_a_recording(tmp_path: Path, ending: str) -> None:
    """macOS puts it beside each file on a foreign disk."""
    write(tmp_path / "walk_0.mcap", ROWS)
    (tmp_path / f"._walk_0.{ending}").write_bytes(b"\0\5\x16\7" + bytes(100))
    said = ["._walk_0.mcap, which is hidden"] if ending == "mcap" else []
    assert read(tmp_path) == (len(ROWS), said)


def test_recordings_in_a_folder_are_named(tmp_path: Path) -> None:
    write(tmp_path / "walk/a.mcap", ROWS)
    said = f"found none\nhint: Name one of the recordings in {tmp_path}: walk.\n"
    assert said in refusal("inspect", tmp_path)


def test_attachments_alone_are_no_recording(tmp_path: Path) -> None:
    mcap = Mcap(tmp_path / "a.mcap")
    mcap.attach(1000)
    mcap.close()
    for command in ("inspect", "play"):
        said = f"{tmp_path} has no topics\nhint: Nothing was recorded."
        assert said in refusal(command, tmp_path)


@pytest.mark.parametrize(
    ("header", "said"),
    [
        (b"\0\3\0\0", "CDR with parameter lists"),
        (b"\0\7\0\0", "XCDR2"),
        (b"\0\x0b\0\0", "XCDR2"),
        (b"\0\x60\0\0", "representation 96"),
    ],
)
def test_other_representations_are_not_supported(tmp_path: Path, header: bytes, said: str) -> None:
    write(tmp_path / "a.mcap", [_headed(it, header) for it in ROWS])
    for command in ("inspect", "play"):
        words = f"not supported: {tmp_path / 'a.mcap'} has {ROWS[0].topic} in {said}; little-endian"
        assert words in refusal(command, tmp_path)


def test_big_endian_messages_are_not_supported(tmp_path: Path) -> None:
    message = TYPES.deserialize_cdr(ROWS[-1].payload, ROWS[-1].type)
    big = bytes(TYPES.serialize_cdr(message, ROWS[-1].type, little_endian=False))
    write(tmp_path / "a.mcap", [*ROWS, replace(ROWS[-1], payload=big)])
    said = f"not supported: {tmp_path / 'a.mcap'} has {ROWS[-1].topic} in big-endian CDR"
    assert said in refusal("inspect", tmp_path)


def test_chunks_that_overlap_beyond_the_memory_for_them_are_not_supported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As in a file whose messages are in no order at all."""
    shuffled = random.Random(1).sample(ROWS, len(ROWS))
    write(tmp_path / "a.mcap", shuffled, chunk_size=1000)
    assert read(tmp_path) == (len(ROWS), [])
    monkeypatch.setattr(bag_reader, "_MOST_WAITING_BYTES", 50_000)
    with pytest.raises(RecordingError, match=r"chunks of .* that overlap in time, at most 50000"):
        list(Bag(tmp_path).messages())
    write(tmp_path / "a.mcap", ROWS, chunk_size=1000)
    assert read(tmp_path) == (len(ROWS), [])


def test_a_large_attachment_is_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mcap = Mcap(tmp_path / "a.mcap", use_chunking=False)
    mcap.add(ROWS[:100])
    mcap.attach(100_000)
    mcap.add(ROWS[100:])
    mcap.close()
    monkeypatch.setattr(mcap_file, "MAX_RECORD_BYTES", 50_000)
    assert read(tmp_path) == (len(ROWS), [])


def test_an_index_of_wrong_times_is_told(tmp_path: Path) -> None:
    """By which messages would be in no order, or skipped."""
    mcap = Mcap(tmp_path / "a.mcap")
    mcap.add(ROWS)
    mcap.flush()
    mcap.index[0].message_start_time += 10**9
    mcap.close()
    assert "its index has other times than the messages at byte" in refusal("play", tmp_path)


def test_an_unknown_compression_is_not_called_damage(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    write(file, ROWS, compression=CompressionType.LZ4, index_types=IndexType.NONE)
    file.write_bytes(file.read_bytes().replace(b"\x03\x00\x00\x00lz4", b"\x03\x00\x00\x00xyz"))
    with pytest.raises(RecordingError, match="not supported: chunks compressed with 'xyz'"):
        list(Bag(file).messages())


@pytest.mark.parametrize("compression", CompressionType)
def test_a_damaged_chunk_is_told_whatever_its_compression(
    tmp_path: Path, compression: CompressionType
) -> None:
    file = tmp_path / "a.mcap"
    write(file, ROWS, compression=compression)
    data = bytearray(file.read_bytes())
    begin = data.index(b"\x06") + 300  # within the first chunk
    data[begin : begin + 50] = bytes(50)
    file.write_bytes(data)
    with pytest.raises(RecordingError, match=r"a.mcap is broken: \S"):
        list(Bag(file).messages())


@pytest.mark.parametrize(
    ("mode", "said"),
    [
        (CompressionMode.MESSAGE, "has messages compressed one by one (MESSAGE)"),
        (CompressionMode.FILE, "walk.mcap.zstd is compressed as a whole"),
    ],
)
def test_what_rosbag2_compresses_otherwise_is_not_supported_with_and_without_metadata(
    tmp_path: Path, mode: CompressionMode, said: str
) -> None:
    folder = tmp_path / "walk"
    with_rosbags(folder, ROWS, mode)
    for _ in range(2):
        for command in ("play", "inspect"):
            words = refusal(command, folder)
            assert "not supported: " in words
            assert said in words
        (folder / "metadata.yaml").unlink(missing_ok=True)


def _in_two_files(folder: Path, rows: Rows) -> None:
    write(folder / "a.mcap", rows[::2])
    write(folder / "b.mcap", rows[1::2], use_chunking=False)


@pytest.mark.parametrize(
    "form",
    [
        lambda folder, rows: write(folder / "a.mcap", rows, chunk_size=1 << 20),
        lambda folder, rows: write(folder / "a.mcap", rows, use_chunking=False),
        lambda folder, rows: write(
            folder / "a.mcap", [Row(*_key(it), 7, it.payload) for it in rows]
        ),
        _in_two_files,
    ],
)
def test_memory_does_not_grow_with_the_recording(
    tmp_path: Path, form: Callable[[Path, Rows], None]
) -> None:
    payloads = (struct.pack("<II", 0x0100, n) + bytes(199_992) for n in range(400))
    form(tmp_path, [Row("/a", STRING, BEGIN_NS + n, it) for n, it in enumerate(payloads)])
    tracemalloc.start()
    count, _ = read(tmp_path)
    _, most_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert count == 400
    assert most_bytes < 20_000_000 < count * 200_000 / 3


def _key(row: Row) -> tuple[str, str]:
    return row.topic, row.type


def test_a_reader_takes_the_topics_of_no_headset(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", [*ROWS, text("/slam/config", "hello")])
    assert "/slam/config" in BagReader(tmp_path).types

"""One recording in the forms that other programs, splits and repairs leave it in."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import CompressionType, IndexType, Writer
from rosbags.rosbag2 import CompressionMode

import ros_messages
from bags import write_bag
from ml2_receiver.session.streams import Request
from sound_bag import BEGIN_NS, IMU, config, sound

# For the streams of sound_rows().
REQUEST: Request = {
    "world_left": {"stream": 0, "format": "Grayscale"},
    "imu_left": {},
    "tf": {"layout": "flat"},
}
NOISE = [
    f"--{sensor}-{kind}=0.001"
    for sensor in ("accelerometer", "gyroscope")
    for kind in ("noise-density", "random-walk")
]
STRING = "std_msgs/msg/String"
DATES = "walk_2026-11-26-10-59-30.mcap", "walk_2026-11-26-11-00-00.mcap"


@dataclass(frozen=True)
class Row:
    """A message; `type` is empty for a channel without a schema."""

    topic: str
    type: str
    time_ns: int
    payload: bytes
    encoding: str = "cdr"


type Rows = Sequence[Row]


def sound_rows(name: str = "") -> list[Row]:
    """Three seconds of a headset: a camera, an IMU, transforms, and the configuration.

    Args:
        name: of the receiver, which is before topics and frames; all share /tf.
    """
    found = []
    for it in sorted([config(), *sound()], key=lambda it: it.log_ns):
        topic = f"/{name}{it.topic}" if name and it.topic != "/tf" else it.topic
        frames = [f"{name}/{frame}" if name else frame for frame in (it.frame, it.parent)]
        named = replace(it, frame=frames[0], parent=frames[1])
        found.append(Row(topic, it.type, it.log_ns, named.encoded()))
    return found


def text(topic: str, words: str, number: int = 0, encoding: str = "cdr") -> Row:
    return Row(topic, STRING, BEGIN_NS + number, ros_messages.string(words), encoding)


class Mcap:
    """A file that is written by the mcap library, which a test may leave unfinished."""

    def __init__(self, file: Path, **options: Any) -> None:
        file.parent.mkdir(exist_ok=True)
        self._stream = file.open("wb")
        self._writer = Writer(self._stream, **{"chunk_size": 64 << 10, **options})
        self._writer.start("ros2", "test")
        self._chunks = self._writer._Writer__chunk_builder  # type: ignore[attr-defined]
        self._channels: dict[tuple[str, str, str], int] = {}

    def add(self, rows: Iterable[Row]) -> None:
        for it in rows:
            key = it.topic, it.type, it.encoding
            if key not in self._channels:
                has_schema = bool(it.type)
                schema = has_schema and self._writer.register_schema(it.type, "ros2msg", b"")
                self._channels[key] = self._writer.register_channel(it.topic, it.encoding, schema)
            self._writer.add_message(self._channels[key], it.time_ns, it.payload, it.time_ns)

    def add_outside(self, rows: Iterable[Row]) -> None:
        """Adds messages outside of chunks."""
        self.flush()
        self._writer._Writer__chunk_builder = None  # type: ignore[attr-defined]
        self.add(rows)
        self.flush()
        self._writer._Writer__chunk_builder = self._chunks  # type: ignore[attr-defined]

    def attach(self, size: int) -> None:
        self._writer.add_attachment(0, 0, "notes", "text/plain", bytes(size))

    @property
    def index(self) -> Any:
        """The index of the written chunks."""
        return self._writer._Writer__chunk_indices  # type: ignore[attr-defined]

    def flush(self) -> None:
        self._writer.flush()

    def close(self, *, is_finished: bool = True) -> None:
        if is_finished:
            self._writer.finish()
        self._stream.close()


def write(file: Path, rows: Iterable[Row], *, is_finished: bool = True, **options: Any) -> None:
    mcap = Mcap(file, **options)
    mcap.add(rows)
    mcap.flush()
    mcap.close(is_finished=is_finished)


def split(folder: Path, rows: Rows, *names: str) -> None:
    size = -(-len(rows) // len(names))
    for number, name in enumerate(names):
        write(folder / name, rows[number * size : (number + 1) * size])


def with_rosbags(
    folder: Path, rows: Rows, compression: CompressionMode = CompressionMode.NONE
) -> None:
    types = {it.topic: it.type for it in rows}
    write_bag(folder, types, ((it.topic, it.time_ns, it.payload) for it in rows), compression)


def like_rosbag2(folder: Path, rows: Rows) -> None:
    """Two splits whose names do not tell their order, and metadata.yaml that does."""
    names = ["walk_10.mcap", "walk_9.mcap"]
    split(folder, rows, *names)
    counts = Counter((it.topic, it.type) for it in rows)
    topics = [
        {"topic_metadata": {"name": topic, "type": type, "serialization_format": "cdr",
            "offered_qos_profiles": ""}, "message_count": count}
        for (topic, type), count in counts.items()
    ]  # fmt: skip
    information = {
        "version": 5,
        "storage_identifier": "mcap",
        "relative_file_paths": names,
        "duration": {"nanoseconds": rows[-1].time_ns - rows[0].time_ns},
        "starting_time": {"nanoseconds_since_epoch": rows[0].time_ns},
        "message_count": len(rows),
        "topics_with_message_count": topics,
        "compression_format": "",
        "compression_mode": "",
        "files": [],
    }
    document = yaml.safe_dump({"rosbag2_bagfile_information": information})
    (folder / "metadata.yaml").write_text(document)


def _by_topic(folder: Path, rows: Rows) -> None:
    """The IMU in a file of its own, from the same time on, not in chunks."""
    write(folder / "a.mcap", [it for it in rows if it.topic == IMU], use_chunking=False)
    write(folder / "b.mcap", [it for it in rows if it.topic != IMU])


def _partly_in_chunks(folder: Path, rows: Rows) -> None:
    mcap = Mcap(folder / "a.mcap")
    for begin in range(0, len(rows), 100):
        (mcap.add_outside if begin % 200 else mcap.add)(rows[begin : begin + 100])
    mcap.close()


def _one_in_chunks(folder: Path, rows: Rows) -> None:
    half = len(rows) // 2
    write(folder / "a.mcap", rows[:half], use_chunking=False)
    write(folder / "b.mcap", rows[half:])


def _copied(
    folder: Path, rows: Rows, of: slice, *, is_finished: bool = True, **options: Any
) -> None:
    write(folder / "walk_0.mcap", rows, is_finished=is_finished)
    write(folder / "recovered.mcap", rows[of], **options)


def _repeated(folder: Path, rows: Rows) -> None:
    """A recorder repeats the latched messages at the beginning of each file."""
    half = len(rows) // 2
    write(folder / "a.mcap", rows[:half])
    write(folder / "b.mcap", [rows[0], *rows[half:]])


def _topic_after_topic(folder: Path, rows: Rows) -> None:
    write(folder / "a.mcap", sorted(rows, key=lambda it: it.topic))


def _with_others(folder: Path, rows: Rows) -> None:
    others = [
        text("/slam/config", "hello"),
        text("/x/app/config", '{"headset": 7}'),
        text("/magic_leap2/custom/config", '{"headset": "h", "session": "s", "streams": {}}'),
        text("/magic_leap2/custom/metadata", "no JSON"),
        text("/notes", "{}", encoding="json"),
        Row("/raw", "", BEGIN_NS, b"\0\1" + bytes(6)),
    ]
    write(folder / "a.mcap", [*others, *rows])


def _with_attachments(folder: Path, rows: Rows) -> None:
    mcap = Mcap(folder / "a.mcap", index_types=IndexType.NONE)
    mcap.add(rows[:200])
    mcap.attach(1000)
    mcap.add(rows[200:])
    mcap.close()


def _beside_an_empty_file(folder: Path, rows: Rows) -> None:
    write(folder / "a.mcap", rows)
    (folder / "b.mcap").touch()


def _one_file(**options: Any) -> Callable[[Path, Rows], None]:
    return lambda folder, rows: write(folder / "walk_0.mcap", rows, **options)


# Functions that write rows into a folder, so that a careful reader finds each of them once.
FORMS: dict[str, Callable[[Path, Rows], None]] = {
    "zstd": _one_file(compression=CompressionType.ZSTD),
    "lz4": _one_file(compression=CompressionType.LZ4),
    "uncompressed": _one_file(compression=CompressionType.NONE),
    "no chunks": _one_file(use_chunking=False),
    "no chunks, and CRCs": _one_file(use_chunking=False, enable_data_crcs=True),
    "one chunk": _one_file(chunk_size=1 << 30),
    "a chunk per message": _one_file(chunk_size=1),
    "no repeated channels": _one_file(repeat_channels=False),
    "no repeated schemas": _one_file(repeat_schemas=False),
    "neither": _one_file(repeat_schemas=False, repeat_channels=False),
    "no statistics": _one_file(use_statistics=False),
    "no summary offsets": _one_file(use_summary_offsets=False),
    "no CRCs": _one_file(enable_crcs=False),
    "no index": _one_file(index_types=IndexType.NONE),
    "an index of chunks": _one_file(index_types=IndexType.CHUNK),
    "an index of messages": _one_file(index_types=IndexType.MESSAGE),
    "no summary": _one_file(
        index_types=IndexType.NONE,
        repeat_channels=False,
        repeat_schemas=False,
        use_statistics=False,
        use_summary_offsets=False,
    ),
    "not finished": _one_file(is_finished=False),
    "partly in chunks": _partly_in_chunks,
    "one of two files in chunks": _one_in_chunks,
    "names with dates": lambda folder, rows: split(folder, rows, *DATES),
    "names against the order": lambda folder, rows: split(folder, rows, "z.mcap", "y.mcap"),
    "files by topic": _by_topic,
    "topic after topic": _topic_after_topic,
    "backwards": lambda folder, rows: write(folder / "a.mcap", rows[::-1]),
    "a whole copy": lambda folder, rows: _copied(folder, rows, slice(None)),
    "a copy without its beginning": lambda folder, rows: _copied(folder, rows, slice(300, None)),
    "a copy without its end": lambda folder, rows: _copied(folder, rows, slice(300)),
    "a copy of what was not finished": lambda folder, rows: _copied(
        folder, rows, slice(100, 900), is_finished=False, use_chunking=False
    ),
    "latched messages again": _repeated,
    "topics of others": _with_others,
    "attachments": _with_attachments,
    "an empty file": _beside_an_empty_file,
    "rosbags": with_rosbags,
    "rosbags, compressed": lambda folder, rows: with_rosbags(folder, rows, CompressionMode.STORAGE),
    "rosbag2": like_rosbag2,
}

"""Files that are said to be recordings: they are read, or refused in words."""

import io
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from mcap.writer import CompressionType, Writer

from ml2_receiver.errors import RecordingError
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.config_topic import ConfigText, StreamEntry
from ml2_receiver.topics.plain_messages import encode_string
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.bags.indexed_bag import History, IndexedBag
from ml2_tools.playback.answers import Repertoire
from vectors import vectors

_BATTERY = StreamEntry("applied", {}, None, [])
_CONFIG = ConfigText("h", "s", {"battery": _BATTERY}).to_bytes().decode()
_FILE = Path(tempfile.mkdtemp(prefix="ml2_fuzz_"), "recording.mcap")
_MOST_BYTES = 64 << 20


def seeds() -> Iterator[bytes]:
    """Without CRCs, which would refuse whatever is changed."""
    for compression in CompressionType:
        for is_chunked in True, False:
            yield _recording(compression, is_chunked=is_chunked)


def _recording(compression: CompressionType, *, is_chunked: bool) -> bytes:
    file = io.BytesIO()
    writer = Writer(file, compression=compression, use_chunking=is_chunked, enable_crcs=False)
    writer.start("ros2", "fuzz")
    ((_, battery),) = vectors("cdr", "BatteryState")
    messages = {
        "/p/config": ("std_msgs/msg/String", encode_string(_CONFIG)),
        "/p/battery": ("sensor_msgs/msg/BatteryState", battery),
    }
    for topic, (type, payload) in messages.items():
        schema = writer.register_schema(type, "ros2msg", b"")
        channel = writer.register_channel(topic, "cdr", schema)
        writer.add_message(channel, 1, payload, 1)
    writer.finish()
    return file.getvalue()


def read(data: bytes) -> None:
    _FILE.write_bytes(data)
    with suppress(RecordingError):
        reader = BagReader(_FILE)
        Repertoire.of(reader, load_table()).answers({"battery": {}})
        for message in reader.messages():
            assert len(message.payload) <= _MOST_BYTES
    with suppress(RecordingError):
        bag = IndexedBag(_FILE)
        for message in bag.until(1, {"/p/battery": History(1, None)}):
            assert (message.topic, message.time_ns <= 1) == ("/p/battery", True)
        for message in bag.after(0):
            assert message.time_ns > 0

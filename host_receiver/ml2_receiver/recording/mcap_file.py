"""One MCAP file of a recording."""

import os
from collections.abc import Iterable
from pathlib import Path

from mcap.records import Channel, Schema
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from ..generated.type_hashes import HASHES
from ..generated.version import VERSION
from ..private_files import create_private_file
from .bag_metadata import BagFile, to_yaml
from .bag_topic import BagTopic
from .mcap_end import end_file
from .message_definitions import DEFINITIONS

_CHUNK_BYTES = 4 << 20
COMPRESSIONS = {"none": CompressionType.NONE, "zstd": CompressionType.ZSTD}


class McapFile:
    """One MCAP file that is being written; only its owner can read it. Not thread-safe.

    All methods but cut() raise OSError if the disk fails.

    Args:
        path: the file, which must not exist.
        compression: a key of COMPRESSIONS, for chunks.
        topics: the topics to announce at the beginning.

    Attributes:
        contents: the numbers and times of its messages.
        flushed_bytes: the bytes that survive a kill of this process.
    """

    def __init__(self, path: Path, compression: str, topics: Iterable[BagTopic]) -> None:
        self.contents = BagFile(path.name)
        self.flushed_bytes = 0
        self._channels: dict[BagTopic, Channel] = {}
        self._schemas: dict[str, Schema] = {}
        self._file = create_private_file(path)
        self._writer = Writer(self._file, _CHUNK_BYTES, COMPRESSIONS[compression])
        self._writer.start(Profile.ROS2, f"ml2-receiver {VERSION}")
        for topic in topics:
            self.add_topic(topic)
        self.flush()

    def add_topic(self, topic: BagTopic) -> None:
        """Announces a topic, once; the definition of a type that no stream has stays empty."""
        schema = self._schemas.get(topic.type)
        if schema is None:
            data = DEFINITIONS.get(topic.type, "").encode()
            encoding = SchemaEncoding.ROS2 if data else SchemaEncoding.SelfDescribing
            id = self._writer.register_schema(topic.type, encoding, data)
            schema = self._schemas[topic.type] = Schema(id, data, encoding, topic.type)
        metadata = {
            "offered_qos_profiles": to_yaml(topic.offered_qos_profiles()).rstrip(),
            "topic_type_hash": HASHES.get(topic.type, ""),
        }
        channel = (topic.name, MessageEncoding.CDR, schema.id, metadata)
        id = self._writer.register_channel(*channel)
        self._channels[topic] = Channel(id, topic.name, MessageEncoding.CDR, metadata, schema.id)
        self.contents.message_counts[topic] = 0

    def write(self, topic: BagTopic, time_ns: int, payload: bytes) -> None:
        """Adds a message of an announced topic; it is on disk after the next flush()."""
        sequence = self.contents.message_counts[topic]
        self._writer.add_message(self._channels[topic].id, time_ns, payload, time_ns, sequence)
        self.contents.count(topic, time_ns)

    def flush(self) -> None:
        """Ends the chunk, so that all messages survive the end of this process."""
        if not os.fstat(self._file.fileno()).st_nlink:
            raise FileNotFoundError(0, "somebody has removed its file")
        self._writer.flush()
        self.flushed_bytes = self._file.tell()

    def finish(self, metadata: str | None) -> None:
        """Writes the index, and rosbag2's metadata if given; the last call."""
        self.flush()
        if metadata is not None:
            self._writer.add_metadata("rosbag2", {"serialized_metadata": metadata})
        self._writer.finish()
        self._file.flush()
        self.flushed_bytes = self._file.tell()
        self._file.close()

    def cut(self) -> None:
        """Ends the file after the flushed messages, with an index if the disk has space.

        Nothing may be called after it.
        """
        if self._file.closed:
            return  # The file has its index
        file = os.dup(self._file.fileno())
        self._file.raw.close()  # Closing the buffer would write more
        try:
            schemas, channels = list(self._schemas.values()), list(self._channels.values())
            kept = end_file(file, self.flushed_bytes, schemas, channels)
        except OSError:
            return  # The disk takes nothing any more
        finally:
            os.close(file)
        self.flushed_bytes = kept.file_bytes
        self.contents.first_ns = kept.first_ns if kept.counts else None
        self.contents.last_ns = kept.last_ns
        self.contents.message_counts = {
            topic: kept.counts[channel.id] for topic, channel in self._channels.items()
        }

"""Writes a rosbag2 folder."""

import os
from pathlib import Path

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from ..generated.message_definitions import DEFINITIONS, HASHES
from ..generated.version import VERSION
from .bag_folder import METADATA
from .bag_metadata import BagMetadata, to_yaml
from .bag_topic import BagTopic

_CHUNK_BYTES = 4 << 20
COMPRESSIONS = {"none": CompressionType.NONE, "zstd": CompressionType.ZSTD}


class BagWriter:
    """FOLDER/metadata.yaml and FOLDER/FOLDER_0.mcap. Not thread-safe.

    All methods raise OSError when the disk does not take what they write; abandon() then.

    Args:
        folder: exists and is empty.
        compression: a key of COMPRESSIONS, for chunks.
    """

    def __init__(self, folder: Path, compression: str) -> None:
        self._folder = folder
        name = folder.resolve().name
        self.metadata = BagMetadata(f"{name}_0.mcap")
        self.flushed_bytes = 0
        self._channels: dict[BagTopic, int] = {}
        self._schemas: dict[str, int] = {}
        self._file = (folder / self.metadata.file_name).open("wb")
        self._writer = Writer(self._file, _CHUNK_BYTES, COMPRESSIONS[compression])
        self._writer.start(Profile.ROS2, f"ml2-receiver {VERSION}")
        self.flush()
        self.write_metadata()

    def add_topic(self, topic: BagTopic) -> None:
        """Announces a topic, once; of types that no stream has the definition stays empty."""
        if topic.type not in self._schemas:
            definition = DEFINITIONS.get(topic.type, "")
            encoding = SchemaEncoding.ROS2 if definition else SchemaEncoding.SelfDescribing
            self._schemas[topic.type] = self._writer.register_schema(
                topic.type, encoding, definition.encode()
            )
        self._channels[topic] = self._writer.register_channel(
            topic.name,
            MessageEncoding.CDR,
            self._schemas[topic.type],
            {
                "offered_qos_profiles": to_yaml(topic.offered_qos_profiles()).rstrip(),
                "topic_type_hash": HASHES.get(topic.type, ""),
            },
        )
        self.metadata.message_counts[topic] = 0

    def write(self, topic: BagTopic, time_ns: int, payload: bytes) -> None:
        """Adds a message of an announced topic; it is on disk after the next flush()."""
        sequence = self.metadata.message_counts[topic]
        self._writer.add_message(self._channels[topic], time_ns, payload, time_ns, sequence)
        self.metadata.count(topic, time_ns)

    def flush(self) -> None:
        """Ends the chunk: what was written survives the end of this process."""
        self._writer.flush()
        self.flushed_bytes = self._file.tell()

    def write_metadata(self) -> None:
        """Replaces metadata.yaml, which is whole at any moment."""
        draft = self._folder / f"{METADATA}.draft"
        draft.write_text(self.metadata.to_yaml(), "utf-8")
        draft.replace(self._folder / METADATA)

    def close(self) -> None:
        """Writes the index; nothing may be called after."""
        self._writer.flush()
        self._writer.add_metadata(
            "rosbag2", {"serialized_metadata": self.metadata.information_yaml()}
        )
        self._writer.finish()
        self._file.close()
        self.flushed_bytes = (self._folder / self.metadata.file_name).stat().st_size
        self.write_metadata()

    def abandon(self) -> None:
        """Leaves what was flushed, without an index; the disk may be full."""
        self._file.raw.close()  # unlike the buffer's, writes nothing more
        os.truncate(self._folder / self.metadata.file_name, self.flushed_bytes)

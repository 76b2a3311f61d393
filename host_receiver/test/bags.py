"""Writes recordings by rosbags, which shares nothing with the product's own writer; counts."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import yaml
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from ros_messages import TYPES

type Messages = Iterable[tuple[str, int, bytes]]


def write_bag(
    folder: Path,
    types: Mapping[str, str],
    messages: Messages,
    compression: CompressionMode = CompressionMode.NONE,
) -> None:
    """An MCAP of topics, times in ns and payloads; `types` are by topic."""
    bag = Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP)
    bag.set_compression(compression, CompressionFormat.ZSTD)
    with bag as writer:
        connections = {
            topic: writer.add_connection(topic, type, typestore=TYPES)
            for topic, type in types.items()
        }
        for topic, time_ns, payload in messages:
            writer.write(connections[topic], time_ns, payload)


def message_counts(bag: Path) -> dict[str, int]:
    """Returns the messages by topic, which a recorder also writes while it records."""
    file = bag / "metadata.yaml"
    if not file.exists():
        return {}
    information = yaml.safe_load(file.read_text())["rosbag2_bagfile_information"]
    topics = information["topics_with_message_count"]
    return {it["topic_metadata"]["name"]: it["message_count"] for it in topics}

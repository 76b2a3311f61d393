"""Writes recordings by rosbags, which shares nothing with the product's own writer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

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

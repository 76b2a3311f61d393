"""Writes a rosbag2 folder."""

from contextlib import suppress
from pathlib import Path

from .bag_metadata import BagMetadata
from .bag_topic import BagTopic
from .mcap_file import McapFile
from .metadata_file import MetadataFile


class BagWriter:
    """FOLDER/metadata.yaml and FOLDER/FOLDER_0.mcap, FOLDER_1.mcap and so on. Not thread-safe.

    All methods raise OSError if the disk fails; then call abandon().

    Args:
        folder: an empty folder.
        compression: a key of COMPRESSIONS, for chunks.
        split_bytes: the next flush() begins another file when a file has this size.
        split_ns: the same for the time from a file's first message to its last. 0 is no limit.
    """

    def __init__(
        self, folder: Path, compression: str, split_bytes: int = 0, split_ns: int = 0
    ) -> None:
        self.folder = folder
        self._compression, self._split_bytes, self._split_ns = compression, split_bytes, split_ns
        self._ended_bytes = 0
        self.metadata = BagMetadata()
        self._file = self._next_file()
        self._metadata_file = MetadataFile(folder, self.metadata.to_yaml())

    @property
    def flushed_bytes(self) -> int:
        """The number of flushed bytes of all files."""
        return self._ended_bytes + self._file.flushed_bytes

    def add_topic(self, topic: BagTopic) -> None:
        """Announces a topic, once."""
        self._file.add_topic(topic)

    def write(self, topic: BagTopic, time_ns: int, payload: bytes) -> None:
        """Adds a message of an announced topic; it is on disk after the next flush()."""
        self._file.write(topic, time_ns, payload)

    def flush(self) -> None:
        """Flushes all messages, so that they survive the end of this process."""
        self._file.flush()
        if self._is_full():
            self._file.finish(None)
            following = self._next_file()
            self._ended_bytes += self._file.flushed_bytes
            self._file = following
            self.write_metadata()

    def write_metadata(self) -> None:
        """Replaces metadata.yaml soon."""
        self._metadata_file.replace(self.metadata.to_yaml())

    def close(self) -> None:
        """Writes the index; the last call."""
        self._file.finish(self.metadata.information_yaml())
        self._metadata_file.close(self.metadata.to_yaml())

    def abandon(self) -> None:
        """Ends the file after the flushed messages, with an index if the disk has space.

        Raises nothing.
        """
        self._file.cut()
        with suppress(OSError):
            self._metadata_file.close(self.metadata.to_yaml())

    def _is_full(self) -> bool:
        contents = self._file.contents
        return bool(contents.message_count) and (
            0 < self._split_bytes <= self._file.flushed_bytes
            or 0 < self._split_ns <= contents.duration_ns
        )

    def _next_file(self) -> McapFile:
        path = self.folder / f"{self.folder.resolve().name}_{len(self.metadata.files)}.mcap"
        try:
            file = McapFile(path, self._compression, self.metadata.topics())
        except OSError:
            path.unlink(missing_ok=True)
            raise
        self.metadata.files.append(file.contents)
        return file

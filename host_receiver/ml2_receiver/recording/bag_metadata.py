"""metadata.yaml, which makes a folder a rosbag2, in the version that ROS 2 Jazzy writes."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import yaml

from ..generated.type_hashes import HASHES
from .bag_topic import BagTopic

_VERSION = 9  # rosbag2_storage/bag_metadata.hpp of Jazzy


@dataclass
class BagFile:
    """The content of one file; times are those of reception, in ns."""

    name: str
    first_ns: int | None = None
    last_ns: int = 0
    message_counts: dict[BagTopic, int] = field(default_factory=dict)

    @property
    def message_count(self) -> int:
        return sum(self.message_counts.values())

    @property
    def duration_ns(self) -> int:
        return 0 if self.first_ns is None else self.last_ns - self.first_ns

    def count(self, topic: BagTopic, time_ns: int) -> None:
        """Counts a message."""
        self.message_counts[topic] += 1
        self.first_ns = time_ns if self.first_ns is None else min(self.first_ns, time_ns)
        self.last_ns = max(self.last_ns, time_ns)

    def information(self) -> dict[str, Any]:
        return {"path": self.name, **_span([self])}


@dataclass
class BagMetadata:
    """The content of all files."""

    files: list[BagFile] = field(default_factory=list)

    @property
    def duration_ns(self) -> int:
        """The time from the first message to the last."""
        first_ns, last_ns = _times(self.files)
        return last_ns - first_ns

    def topics(self) -> list[BagTopic]:
        """Returns all topics: each file has the topics of the previous one, too."""
        return list(self.files[-1].message_counts) if self.files else []

    def message_counts(self) -> Counter[BagTopic]:
        """Returns the number of messages of each topic."""
        counts = Counter(dict.fromkeys(self.topics(), 0))
        for file in self.files:
            counts.update(file.message_counts)
        return counts

    def to_yaml(self) -> str:
        """Returns the text of metadata.yaml."""
        return to_yaml({"rosbag2_bagfile_information": self._information()})

    def information_yaml(self) -> str:
        """Returns the metadata as rosbag2 repeats it inside the MCAP file."""
        return to_yaml(self._information())

    def _information(self) -> dict[str, Any]:
        return {
            "version": _VERSION,
            "storage_identifier": "mcap",
            **_span(self.files),
            "topics_with_message_count": [
                {"topic_metadata": _topic(topic), "message_count": count}
                for topic, count in self.message_counts().items()
            ],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [file.name for file in self.files],
            "files": [file.information() for file in self.files],
            "custom_data": None,
            "ros_distro": "jazzy",
        }


def _span(files: Sequence[BagFile]) -> dict[str, Any]:
    first_ns, last_ns = _times(files)
    return {
        "duration": {"nanoseconds": last_ns - first_ns},
        "starting_time": {"nanoseconds_since_epoch": first_ns},
        "message_count": sum(it.message_count for it in files),
    }


def _times(files: Sequence[BagFile]) -> tuple[int, int]:
    """Returns the times of the first and the last message."""
    spans = [(it.first_ns, it.last_ns) for it in files if it.first_ns is not None]
    return min((it[0] for it in spans), default=0), max((it[1] for it in spans), default=0)


def _topic(topic: BagTopic) -> dict[str, Any]:
    return {
        "name": topic.name,
        "type": topic.type,
        "serialization_format": "cdr",
        "offered_qos_profiles": topic.offered_qos_profiles(),
        "type_description_hash": HASHES.get(topic.type, ""),
    }


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """libyaml's dumper if PyYAML has it, ten times faster; writes no YAML aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def to_yaml(value: Any) -> str:
    """Returns YAML with keys in the order of the mapping."""
    text: str = yaml.dump(value, Dumper=_Dumper, sort_keys=False)
    return text

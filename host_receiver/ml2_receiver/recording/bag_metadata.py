"""metadata.yaml, which makes a folder a rosbag2, in the version that ROS 2 Jazzy writes."""

from dataclasses import dataclass, field
from typing import Any

import yaml

from ..generated.message_definitions import HASHES
from .bag_topic import BagTopic

_VERSION = 9  # rosbag2_storage/bag_metadata.hpp of Jazzy


@dataclass
class BagMetadata:
    """What is in one file; times are those messages were received at, in ns."""

    file_name: str
    first_ns: int | None = None
    last_ns: int = 0
    message_counts: dict[BagTopic, int] = field(default_factory=dict)

    @property
    def message_count(self) -> int:
        return sum(self.message_counts.values())

    def count(self, topic: BagTopic, time_ns: int) -> None:
        """One more message."""
        self.message_counts[topic] += 1
        self.first_ns = time_ns if self.first_ns is None else min(self.first_ns, time_ns)
        self.last_ns = max(self.last_ns, time_ns)

    def to_yaml(self) -> str:
        """The text of metadata.yaml."""
        return to_yaml({"rosbag2_bagfile_information": self._information()})

    def information_yaml(self) -> str:
        """As rosbag2 repeats it inside the file."""
        return to_yaml(self._information())

    def _information(self) -> dict[str, Any]:
        first_ns = self.first_ns or 0
        span = {
            "duration": {"nanoseconds": self.last_ns - first_ns},
            "starting_time": {"nanoseconds_since_epoch": first_ns},
            "message_count": self.message_count,
        }
        return {
            "version": _VERSION,
            "storage_identifier": "mcap",
            **span,
            "topics_with_message_count": [
                {"topic_metadata": _topic(topic), "message_count": count}
                for topic, count in self.message_counts.items()
            ],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self.file_name],
            "files": [{"path": self.file_name, **span}],
            "custom_data": None,
            "ros_distro": "jazzy",
        }


def _topic(topic: BagTopic) -> dict[str, Any]:
    return {
        "name": topic.name,
        "type": topic.type,
        "serialization_format": "cdr",
        "offered_qos_profiles": topic.offered_qos_profiles(),
        "type_description_hash": HASHES.get(topic.type, ""),
    }


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """libyaml's where PyYAML has it, ten times faster; writes out what occurs twice."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def to_yaml(value: Any) -> str:
    """In the order of its keys."""
    text: str = yaml.dump(value, Dumper=_Dumper, sort_keys=False)
    return text

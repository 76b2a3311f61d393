"""Keys, liveliness tokens and attachments as rmw_zenoh of ROS 2 Jazzy writes them.

rmw_zenoh has had this form of attachments since its version 0.2.4. Its nodes ignore what has
another form.
"""

import struct
from dataclasses import dataclass

import xxhash

from ..errors import PublishError
from ..generated.type_hashes import HASHES
from ..table.stream_table import Qos

_GID_BYTES = 16
_ATTACHMENT = struct.Struct(f"<qqB{_GID_BYTES}s")
_DEFAULT_DEPTH = 42
NODE_NAME = "ml2_receiver"


@dataclass(frozen=True)
class TopicName:
    """A topic; `name` is absolute, `type` such as "sensor_msgs/msg/Image".

    Raises:
        PublishError: the hash of the type is not known.
    """

    name: str
    type: str
    qos: Qos

    def __post_init__(self) -> None:
        if self.type not in HASHES:
            raise PublishError(
                f"{self.name} is not published on Zenoh: expected a type of diagnostic_msgs,"
                f" geometry_msgs, sensor_msgs or std_msgs, found {self.type}"
            )

    def key(self, domain: int) -> str:
        """Returns the key of its messages in a ROS domain."""
        return f"{domain}/{self.name.strip('/')}/{self._type}/{HASHES[self.type]}"

    @property
    def part_of_token(self) -> str:
        return f"{_without_slashes(self.name)}/{self._type}/{HASHES[self.type]}/{_qos(self.qos)}"

    @property
    def _type(self) -> str:
        return f"{self.type.replace('/msg/', '::msg::dds_::')}_"


@dataclass(frozen=True)
class Node:
    """A node.

    Attributes:
        domain: the ROS domain id.
        session: the id of the Zenoh session, in hexadecimal digits.
        receiver: as in --name, the node's namespace; may be empty.
        name: after the remappings of ROS's arguments.
    """

    domain: int
    session: str
    receiver: str
    name: str = NODE_NAME

    def token(self) -> str:
        """Returns the liveliness token of the node."""
        return self._token(0, "NN")

    def publisher_token(self, number: int, topic: TopicName) -> str:
        """Returns the liveliness token of its publisher with this number, from 1."""
        return f"{self._token(number, 'MP')}/{topic.part_of_token}"

    def _token(self, number: int, kind: str) -> str:
        namespace = _without_slashes(f"/{self.receiver}")
        return f"@ros2_lv/{self.domain}/{self.session}/0/{number}/{kind}/%/{namespace}/{self.name}"


def gid(token: str) -> bytes:
    """Returns the 16 bytes by which ROS's graph knows the publisher with this token."""
    return xxhash.xxh3_128_digest(token.encode())[::-1]  # low 64 bits first, little endian


def attachment(sequence: int, time_ns: int, gid: bytes) -> bytes:
    """Returns the attachment of a message; `sequence` counts from 1, `time_ns` is UTC."""
    return _ATTACHMENT.pack(sequence, time_ns, _GID_BYTES, gid)


def _without_slashes(name: str) -> str:
    return name.replace("/", "%")


def _qos(qos: Qos) -> str:
    """Returns what differs from rmw_zenoh's default: RELIABLE, VOLATILE, KEEP_LAST of 42."""
    durability = "1" if qos.durability == "transient_local" else ""
    depth = "" if qos.depth == _DEFAULT_DEPTH else str(qos.depth)
    return f":{durability}:,{depth}:,:,:,,"

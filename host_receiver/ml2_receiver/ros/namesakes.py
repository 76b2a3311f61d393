"""Finds nodes whose topics and services mix with those of this receiver."""

from rclpy.node import Node

from ..printable import printable

_FIX = (
    "subscribers and tools get those of both mixed. Start each with a --name of its own, such as"
    " --name robot1, or with another ROS_DOMAIN_ID"
)
_UNKNOWN = "_NODE_NAME_UNKNOWN_"  # ROS hears of a node's topics before its name


class Namesakes:
    """Looks for other nodes in ROS's graph; the thread that spins `node` may use it.

    Args:
        receiver: as in --name, or empty.
        topic: of which this node is meant to be the only publisher.
    """

    def __init__(self, node: Node, receiver: str, topic: str) -> None:
        self._node, self._topic = node, topic
        self._who = f"named {receiver}" if receiver else "without a name"
        self._is_said = False

    def news(self) -> str | None:
        """Returns once, when there is such a node, what is wrong and what to do."""
        if self._is_said or (found := self._found()) is None:
            return None
        self._is_said = True
        return f"{found}: {_FIX}"

    def _found(self) -> str | None:
        own = self._node.get_name(), self._node.get_namespace()
        if self._node.get_node_names_and_namespaces().count(own) > 1:
            return f"another receiver {self._who} is in this ROS domain, with the same topics"
        publishers = self._node.get_publishers_info_by_topic(self._topic)
        names = [(it.node_name, it.node_namespace) for it in publishers]
        other = next((it for it in names if it != own and it[0] != _UNKNOWN), None)
        if other is None:
            return None
        full = printable(f"{other[1].rstrip('/')}/{other[0]}")
        return f"{full} publishes {self._topic} and maybe other topics of this receiver, too"

"""ROS's parameters `qos_overrides`, with which users change the QoS of publishers at the start."""

import re
from collections.abc import Iterable, Iterator
from difflib import get_close_matches

from rclpy.qos import QoSPolicyKind
from rclpy.qos_overriding_options import QoSOverridingOptions

from ..configuration.parameter_file import expected_one_of
from ..table.stream_table import StreamTable

_POLICIES = {
    "depth": QoSPolicyKind.DEPTH,
    "durability": QoSPolicyKind.DURABILITY,
    "history": QoSPolicyKind.HISTORY,
    "reliability": QoSPolicyKind.RELIABILITY,
}
OVERRIDABLE = QoSOverridingOptions(policy_kinds=_POLICIES.values())
_NAME = re.compile(r"qos_overrides\.(?P<topic>/[^.]*)\.(?P<entity>[^.]*)\.(?P<policy>[^.]*)")


def unused(given: Iterable[str], table: StreamTable, prefix: str) -> Iterator[str]:
    """Says of each of the parameters `given` that changes nothing why it does not.

    Args:
        prefix: of the receiver's topics.
    """
    topics = [it.full_name(prefix) for stream in table.streams.values() for it in stream.topics]
    topics += [f"{prefix}/{it.name}" for it in table.receiver_topics]
    custom = f"{prefix}/custom/"
    for name in given:
        found = _NAME.fullmatch(name)
        if found is None:
            reason = "expected qos_overrides.TOPIC.publisher.POLICY"
        elif found["topic"] not in topics and not found["topic"].startswith(custom):
            close = get_close_matches(found["topic"], topics, 1)
            reason = "no topic of this receiver" + (f"; did you mean {close[0]}?" if close else "")
        elif found["entity"] != "publisher":
            reason = f"expected publisher, found {found['entity']}"
        elif found["policy"] not in _POLICIES:
            reason = expected_one_of(list(_POLICIES), found["policy"])
        else:
            continue
        yield f"{name} changes nothing: {reason}"

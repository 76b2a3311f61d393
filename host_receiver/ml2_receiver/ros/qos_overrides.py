"""ROS's parameters `qos_overrides`, with which users change the QoS of publishers at the start."""

import re
from collections.abc import Mapping
from difflib import get_close_matches

from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSPolicyEnum,
    QoSPolicyKind,
    ReliabilityPolicy,
)
from rclpy.qos_overriding_options import QoSOverridingOptions

from ..configuration.parameter_file import expected_one_of
from ..errors import ConfigError, Problem

_POLICIES: Mapping[str, type[QoSPolicyEnum] | None] = {
    "depth": None,
    "durability": DurabilityPolicy,
    "history": HistoryPolicy,
    "reliability": ReliabilityPolicy,
}
OVERRIDABLE = QoSOverridingOptions(policy_kinds=[QoSPolicyKind[it.upper()] for it in _POLICIES])
_NAME = re.compile(r"qos_overrides\.(?P<topic>/[^.]*)\.(?P<entity>[^.]*)\.(?P<policy>[^.]*)")
_MOST_DEPTH = 0x7FFFFFFF  # of DDS


def check(given: Mapping[str, object], topics: Mapping[str, str], custom: str) -> list[str]:
    """Returns what to say of each of the parameters `given` that changes nothing.

    Args:
        topics: of this receiver, with their names after remappings.
        custom: what the names of the app's topics begin with.

    Raises:
        ConfigError: a policy cannot have the value that is given.
    """
    said, problems = [], []
    for name, value in given.items():
        found = _NAME.fullmatch(name)
        if found is None:
            reason = "expected qos_overrides.TOPIC.publisher.POLICY"
        elif found["topic"] not in topics.values() and not found["topic"].startswith(custom):
            reason = _no_topic(found["topic"], topics)
        elif found["entity"] != "publisher":
            reason = f"expected publisher, found {found['entity']}"
        elif found["policy"] not in _POLICIES:
            reason = expected_one_of(list(_POLICIES), found["policy"])
        else:
            if (expected := _expected(_POLICIES[found["policy"]], value)) is not None:
                message = f"{expected}, found {value!r}"
                problems.append(Problem(0, name, str(value), message))
            continue
        said.append(f"{name} changes nothing: {reason}")
    if problems:
        raise ConfigError(problems, "ROS parameters")
    return said


def _no_topic(name: str, topics: Mapping[str, str]) -> str:
    if name in topics:
        return f"the topic is remapped to {topics[name]}"
    close = get_close_matches(name, topics.values(), 1)
    return "no topic of this receiver" + (f"; did you mean {close[0]}?" if close else "")


def _expected(policy: type[QoSPolicyEnum] | None, value: object) -> str | None:
    """Returns what a policy can have, or None if it can have the value."""
    if policy is None:
        is_depth = type(value) is int and 1 <= value <= _MOST_DEPTH
        return None if is_depth else f"expected an integer of 1 to {_MOST_DEPTH}"
    words = [it for it in policy.short_keys() if it != "unknown"]
    return None if value in words else expected_one_of(words, str(value))

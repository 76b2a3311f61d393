"""Runs all checks on a recording."""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

from ml2_receiver.errors import RecordingError

from ..bags.bag_reader import Bag
from .check import VERDICTS, Check, Verdict
from .coverage import coverage
from .partners import partners
from .survey import survey
from .timing import timing
from .transform_stamps import transform_stamps

_MOST_SHOWN = 200


def inspect(bag: Bag, on_bytes: Callable[[int], None] = lambda _: None) -> list[Check]:
    """Checks every topic; reads the recording once.

    Args:
        on_bytes: is called with each payload's length, for a progress bar up to `bag.size_bytes`.

    Raises:
        RecordingError: the file is broken before its end, or no message in it can be checked.
    """
    found = survey(bag, on_bytes)
    checks = [check for name, topic in found.topics.items() for check in timing(name, topic)]
    checks += [*partners(found), *coverage(found), *transform_stamps(found)]
    if worst(checks) != "wrong" and not any(topic.stamps for topic in found.topics.values()):
        topics = ", ".join(f"{name} ({topic.type})" for name, topic in found.topics.items())
        raise RecordingError(
            "nothing here can be checked: expected ROS messages with stamps, found only"
            f" {topics[:_MOST_SHOWN]}"
        )
    return sorted(checks, key=lambda check: check.topic)


def worst(checks: Sequence[Check]) -> Verdict:
    """Returns the worst verdict, or "ok" if there are no checks."""
    return max((check.verdict for check in checks), key=VERDICTS.index, default="ok")


def as_objects(checks: Sequence[Check]) -> list[dict[str, Any]]:
    """Returns the checks as objects for JSON."""
    return [dataclasses.asdict(check) for check in checks]

"""A subscriber in a process of its own that keeps every payload, for the tests to look at.

Usage: subscriber.py PREFIX QOS_DEPTHS OUTPUT [RECEIVER]. It does what the demo's observer does, and
at the end pickles {"snapshot": ..., "qos": {topic: {(reliability, durability)}}, "topics": {topic:
(type, [payload, ...])}, "graph": [every topic there is], "arrivals_s": {topic: [monotonic clock,
...]}, "publishers": {topic: {id of each publisher there ever was}}}.
"""

from __future__ import annotations

import json
import pickle
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

from observer import Observed, Observer, observe, spun_observer


@dataclass
class Kept(Observed):
    """A topic whose payloads are all kept."""

    payloads: list[bytes] = field(default_factory=list)
    arrivals_s: list[float] = field(default_factory=list)

    def take(self, payload: bytes) -> None:
        super().take(payload)
        self.payloads.append(payload)
        self.arrivals_s.append(time.monotonic())


def main(prefix: str, qos_depths: str, output: Path, receiver: str = "") -> None:
    """Runs until the headset has said goodbye."""
    with spun_observer(prefix, json.loads(qos_depths), Kept, receiver) as observer:
        observer.is_configured.wait()
        publishers: dict[str, set[bytes]] = {name: set() for name in observer.topics}
        observe(observer, lambda: note_publishers(observer, publishers))
        kept = {name: o for name, o in observer.topics.items() if isinstance(o, Kept)}
        output.write_bytes(
            pickle.dumps(
                {
                    "snapshot": observer.snapshot(final=True),
                    "qos": {name: _qos(observer, name) for name in kept},
                    "topics": {name: (o.type, o.payloads) for name, o in kept.items()},
                    "arrivals_s": {name: o.arrivals_s for name, o in kept.items()},
                    "publishers": publishers,
                    "graph": [name for name, _ in observer.get_topic_names_and_types()],
                }
            )
        )


def note_publishers(observer: Observer, seen: dict[str, set[bytes]]) -> None:
    """Adds the publishers that are there now."""
    for topic, ids in seen.items():
        ids |= {bytes(p.endpoint_gid) for p in observer.get_publishers_info_by_topic(topic)}


def _qos(observer: Observer, topic: str) -> set[tuple[str, str]]:
    profiles = [p.qos_profile for p in observer.get_publishers_info_by_topic(topic)]
    return {(profile.reliability.name, profile.durability.name) for profile in profiles}


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]), *sys.argv[4:])

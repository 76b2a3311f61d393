"""Runs a subscriber in its own process that keeps every payload for the tests.

Usage: subscriber.py PREFIX QOS_DEPTHS OUTPUT [RECEIVER]. It does the same as the demo's observer.
At the end it pickles the fields of processes.Received to OUTPUT. The payloads are in a second file
next to OUTPUT.
"""

from __future__ import annotations

import json
import pickle
import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Self

from diagnostic_msgs.msg import DiagnosticArray

from observed_topic import Observed
from observer import Observer, observe, spun_observer
from payload_file import Payloads

_DEPTH = 10
# A test that has seen enough ends its session then.
PERIOD_S = 0.25


class StoredTopic(Observed):
    """An observed topic that writes all its payloads to a file."""

    def __init__(
        self, writer: Writer, type: str, stream: str, read_stamp: Callable[[bytes], int]
    ) -> None:
        super().__init__(type, stream, read_stamp)
        self._writer = writer
        self.payloads = Payloads(writer.path)
        self.arrivals_s: list[float] = []

    def take(self, payload: bytes) -> None:
        super().take(payload)
        self.payloads.spans.append(self._writer.write(payload))
        self.arrivals_s.append(time.monotonic())


class Writer:
    """Writes a file in its own thread, because a disk may block; a context manager."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._size = 0
        self._waiting: SimpleQueue[bytes | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Waits until everything is written."""
        self._waiting.put(None)
        self._thread.join()

    def write(self, payload: bytes) -> tuple[int, int]:
        """Queues a payload; returns its offset in the file and its size."""
        begin = self._size
        self._size += len(payload)
        self._waiting.put(payload)
        return begin, len(payload)

    def _run(self) -> None:
        with self.path.open("wb") as file:
            while (payload := self._waiting.get()) is not None:
                file.write(payload)


def main(prefix: str, qos_depths: str, output: Path, receiver: str = "") -> None:
    """Runs until the headset ends its session."""
    with (
        Writer(output.with_suffix(".payloads")) as writer,
        spun_observer(
            prefix, json.loads(qos_depths), partial(StoredTopic, writer), receiver
        ) as observer,
    ):
        observer.is_configured.wait()
        diagnostics: list[bytes] = []
        observer.create_subscription(
            DiagnosticArray, "/diagnostics", diagnostics.append, _DEPTH, raw=True
        )
        publishers: dict[str, set[bytes]] = {name: set() for name in observer.topics}
        observe(observer, lambda: note_publishers(observer, publishers), PERIOD_S)
        kept = {name: o for name, o in observer.topics.items() if isinstance(o, StoredTopic)}
        received = {
            "snapshot": observer.snapshot(final=True),
            "qos": {name: _qos(observer, name) for name in kept},
            "topics": {name: (o.type, o.payloads) for name, o in kept.items()},
            "arrivals_s": {name: o.arrivals_s for name, o in kept.items()},
            "publishers": publishers,
            "diagnostics": diagnostics,
            "graph": [name for name, _ in observer.get_topic_names_and_types()],
        }
        output.write_bytes(pickle.dumps(received))


def note_publishers(observer: Observer, seen: dict[str, set[bytes]]) -> None:
    """Adds the ids of the current publishers."""
    for topic, ids in seen.items():
        ids |= {bytes(p.endpoint_gid) for p in observer.get_publishers_info_by_topic(topic)}


def _qos(observer: Observer, topic: str) -> set[tuple[str, str]]:
    profiles = [p.qos_profile for p in observer.get_publishers_info_by_topic(topic)]
    return {(profile.reliability.name, profile.durability.name) for profile in profiles}


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]), *sys.argv[4:])

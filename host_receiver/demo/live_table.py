"""The demo's table: every stream as it arrives at the observer."""

import os
import sys
import threading
import time
from typing import Any, Self

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ml2_receiver.topics.adaptation import NOTHING_LOWERED
from processors import Load
from report import drops

PATIENCE_S = 20
# By these, nodes of ROS find each other, or do not.
_DISCOVERY = {
    *("CYCLONEDDS_URI", "FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE"),
    *("RMW_IMPLEMENTATION", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_DISCOVERY_SERVER"),
    *("ROS_DOMAIN_ID", "ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS", "ROS_SUPER_CLIENT"),
}
_MIXED = (
    "another receiver publishes the same topics, so this table counts both:"
    " set a ROS_DOMAIN_ID that nobody else in this network uses, and start again"
)


class LiveTable:
    """Redraws itself with each snapshot; on a plain pipe only the last one is printed.

    Says on standard error if the first one does not come.
    """

    def __init__(self, console: Console, prefix: str, source: str) -> None:
        self._prefix = prefix
        self._source = source
        waiting = Text(f"starting the receiver, the {source} headset and the observer ...")
        self._live = Live(waiting, console=console, refresh_per_second=4)
        self._silence = threading.Timer(PATIENCE_S, _say_that_nothing_comes)
        self._began_s: float | None = None
        self._steps: list[Text] = []
        self._adaptation = ""
        self._load = Load()
        self._full: str | None = None

    def __enter__(self) -> Self:
        self._live.start()
        self._silence.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._silence.cancel()
        self._live.stop()
        self._live.console.print()

    def show(self, snapshot: dict[str, Any], simulation: str | None = None) -> None:
        """Draws one snapshot of the observer, and what the simulation has to say."""
        self._silence.cancel()
        refused = [
            Text(f"{name} refused: {answer['reason']}", style="yellow")
            for name, answer in snapshot["streams"].items()
            if answer["result"] == "refused"
        ]
        self._note_step(snapshot)
        notes = [*refused, *self._steps, self._clock(snapshot["clock"])]
        messages = sum(seen["count"] for seen in snapshot["topics"].values())
        if not snapshot["final"]:
            # The final one follows a wait for late messages, in which the processors are idle.
            self._full = self._load.note(messages)
        if snapshot["is_mixed"]:
            notes.append(Text(_MIXED, style="yellow"))
        if self._full:
            notes.append(Text(self._full, style="yellow"))
        if simulation:
            notes.append(Text(simulation, style="yellow"))
        self._live.update(Group(self._table(snapshot), *notes))

    def _note_step(self, snapshot: dict[str, Any]) -> None:
        """Keeps what was lowered for the link, with the time since the first message."""
        if self._began_s is None and any(it["count"] for it in snapshot["topics"].values()):
            self._began_s = time.monotonic()
        words = snapshot["adaptation"]
        is_first = not self._adaptation and words == NOTHING_LOWERED
        if self._began_s is None or words in ("", self._adaptation) or is_first:
            return
        self._adaptation = words
        self._steps.append(Text(f"{time.monotonic() - self._began_s:4.0f} s  {words}"))

    def _table(self, snapshot: dict[str, Any]) -> Table:
        table = Table(title=f"ML2 Sensors, {self._source} headset, topics under {self._prefix}")
        for heading in ("stream", "topic", "type"):
            table.add_column(heading, no_wrap=True)
        for heading in ("Hz", "Mbit/s", "drops", "p50 ms", "p99 ms"):
            table.add_column(heading, justify="right")
        previous_stream = ""
        for name, seen in snapshot["topics"].items():
            span_s = seen["last_s"] - seen["first_s"]
            mbit_per_s = seen["bytes"] * 8e-6 / span_s if span_s > 0 else 0.0
            lost = drops(seen)
            table.add_row(
                seen["stream"] if seen["stream"] != previous_stream else "",
                name.removeprefix(f"{self._prefix}/"),
                seen["type"].replace("/msg/", "/"),
                f"{seen['rate_hz']:.1f}",
                f"{mbit_per_s:.1f}",
                Text(str(lost), style="red" if lost > 0 and snapshot["final"] else ""),
                f"{seen['latency_ms']['p50']:.1f}",
                f"{seen['latency_ms']['p99']:.1f}",
            )
            previous_stream = seen["stream"]
        return table

    @staticmethod
    def _clock(clock: dict[str, str]) -> Text:
        uncertainty_us = int(clock.get("uncertainty_ns", 0)) / 1e3
        state = clock.get("state", "waiting")
        return Text(f"clock {state}, headset to ROS within {uncertainty_us:.0f} us")


def _say_that_nothing_comes() -> None:
    chosen = " ".join(f"{it}={os.environ[it]}" for it in sorted(_DISCOVERY & os.environ.keys()))
    print(
        "still waiting: ROS nodes have not found the receiver. These variables decide what they"
        f" find, so unset those that your shell sets: {chosen}",
        file=sys.stderr,
        flush=True,
    )

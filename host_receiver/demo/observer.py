"""The independent witness of the demo: a process of its own that subscribes to all and counts.

It learns the topics from `<prefix>/config`, as any ROS program could, subscribes to the raw bytes,
waits until each publisher is matched from both sides, lets the headset start through the
receiver's service, and writes one JSON object a line to standard output: a snapshot each second,
and a last one with `"final": true`.
"""

import argparse
import json
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String
from std_srvs.srv import Trigger

from contact_sheet import write_contact_sheet
from ml2_receiver.ros.context import end_node
from ml2_receiver.ros.fastdds import apply_default_profile
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_receiver.ros.spinning import spin_until, wake
from ml2_receiver.topics.adaptation import ADAPTATION
from ml2_receiver.topics.plain_messages import status_name
from ml2_receiver.topics.stamps import stamp_reader
from ml2_tools.live.faults import Faults
from observed_topic import Observed

RECEIVER_NODE = "/ml2_receiver"
# If no message comes for so long at the end, those that are missing were lost. Fast DDS tells of
# missing ones each 3 s.
_LAST_S = 4.0


class Observer(Node):
    """Subscribes to what the receiver says it publishes; one thread spins it."""

    def __init__(
        self,
        prefix: str,
        qos_depths: dict[str, int],
        observed: Callable[[str, str, Callable[[bytes], int]], Observed] = Observed,
        receiver: str = "",
    ) -> None:
        super().__init__("ml2_observer")
        self._qos_depths = qos_depths
        self._observed = observed
        self.topics: dict[str, Observed] = {}
        self.streams: dict[str, Any] = {}
        self.diagnostics: dict[str, dict[str, str]] = {}
        self._raw_node = rclpy.create_node("ml2_observer_raw")
        self._taker: RawTaker | None = None
        self.is_configured = threading.Event()
        self.is_final = threading.Event()
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(String, f"{prefix}/config", self._configure, latched)
        self.create_subscription(DiagnosticArray, "/diagnostics", self._diagnose, 10)
        self._receiver = receiver
        node = f"/{receiver}{RECEIVER_NODE}" if receiver else RECEIVER_NODE
        self._start = self.create_client(Trigger, f"{node}/start")

    def is_matched(self) -> bool:
        """True if discovery has connected every publisher with this subscriber."""
        return all(
            self.count_publishers(topic) > 0 and int(self._of(topic).get("subscribers", 0)) > 0
            for topic in self.topics
        )

    def _of(self, topic: str) -> dict[str, str]:
        return self.diagnostics.get(status_name(self._receiver, topic), {})

    def start_headset(self) -> None:
        """Asks the receiver to let the headset begin."""
        self._start.wait_for_service()
        self._start.call_async(Trigger.Request())

    def _configure(self, message: String) -> None:
        if self.is_configured.is_set():
            return
        applied = json.loads(message.data)
        self.streams = applied["streams"]
        wanted = [
            self._subscription(stream, topic)
            for stream, answer in self.streams.items()
            for topic in answer["topics"]
        ]
        if wanted:
            self._taker = RawTaker(self._raw_node, wanted, Faults().add)
        self.is_configured.set()

    def _subscription(self, stream: str, topic: dict[str, str]) -> RawSubscription:
        observed = self._observed(topic["type"], stream, stamp_reader(topic["type"]))
        self.topics[topic["topic"]] = observed
        qos = QoSProfile(depth=self._qos_depths[topic["qos"]])
        if topic["topic"] == "/tf_static":  # as every listener of it does
            qos.durability = DurabilityPolicy.TRANSIENT_LOCAL
        return RawSubscription(topic["type"], topic["topic"], qos, observed.take)

    def _diagnose(self, message: DiagnosticArray) -> None:
        for status in message.status:
            values = {pair.key: pair.value for pair in status.values}
            self.diagnostics[status.name] = values | {"message": status.message}
        # The last STATUS may be here before everything that it counts.
        if self.session.get("final") == "true" and self.session["state"] != "connected":
            self.is_final.set()

    @property
    def session(self) -> dict[str, str]:
        """The latest diagnostics of the session."""
        return self._of("session")

    @property
    def clock(self) -> dict[str, str]:
        """The latest diagnostics of the headset's clock, empty before the first."""
        return self._of("clock")

    def snapshot(self, final: bool) -> dict[str, Any]:
        """Everything seen so far, for the demo's table and report."""
        topics = {
            name: observed.row()
            | {"diagnostics": self._of(name)}
            | ({"phases_ms": observed.phases(), "gaps_ms": observed.gaps()} if final else {})
            for name, observed in self.topics.items()
        }
        return {
            "final": final,
            "streams": self.streams,
            "session": self.session,
            "clock": self.clock,
            "adaptation": self._of(ADAPTATION).get("message", ""),
            "is_mixed": any(
                self.count_publishers(it) > 1 for it in topics if not it.startswith("/tf")
            ),
            "topics": topics,
        }

    def destroy_node(self) -> None:
        """Stops taking before the subscriptions go."""
        if self._taker is not None:
            self._taker.stop()
        self._raw_node.destroy_node()
        super().destroy_node()  # type: ignore[no-untyped-call]

    @property
    def count(self) -> int:
        """The messages of all topics so far."""
        return sum(it.count for it in self.topics.values())

    def awaits_more(self) -> bool:
        """True if the receiver published messages that have not arrived here."""
        return any(
            observed.count < int(self._of(name).get("received", 0))
            for name, observed in self.topics.items()
        )


def main() -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("--prefix", required=True)
    parser.add_argument("--qos-depths", type=json.loads, required=True)
    parser.add_argument("--pictures", type=Path, required=True)
    parser.add_argument("--arrivals", type=Path, help="write here when each message came")
    parser.add_argument("--receiver", default="", help="its --name")
    arguments = parser.parse_args()
    with spun_observer(
        arguments.prefix, arguments.qos_depths, receiver=arguments.receiver
    ) as observer:
        observe(observer)
        write_contact_sheet(
            {name: (o.type, o.last_payload) for name, o in observer.topics.items() if o.count},
            arguments.pictures,
        )
        if arguments.arrivals:
            arrivals = {name: it.arrivals() for name, it in observer.topics.items()}
            np.savez(arguments.arrivals, **arrivals)  # type: ignore[arg-type]
        print(json.dumps(observer.snapshot(final=True)), flush=True)
    return 0


@contextmanager
def spun_observer(
    prefix: str,
    qos_depths: dict[str, int],
    observed: Callable[[str, str, Callable[[bytes], int]], Observed] = Observed,
    receiver: str = "",
) -> Iterator[Observer]:
    """An observer that a thread spins; the process ends when any of its threads fails."""
    threading.excepthook = _end_process
    _print_apart_from_libraries()
    apply_default_profile(os.environ, sends_images=False)
    rclpy.init()
    observer = Observer(prefix, qos_depths, observed, receiver)
    executor = SingleThreadedExecutor()
    executor.add_node(observer)
    is_closing = threading.Event()
    spinner = threading.Thread(target=spin_until, args=[executor, is_closing.is_set])
    spinner.start()
    try:
        yield observer
    finally:
        is_closing.set()
        wake(executor)  # a shutdown would take from the spinner what it waits with
        spinner.join()
        executor.shutdown()
        end_node(observer)


def _print_apart_from_libraries() -> None:
    """Leaves standard output to print: logs of ROS and Fast DDS go to standard error."""
    output = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    sys.stdout = os.fdopen(output, "w")


def _end_process(failure: threading.ExceptHookArgs) -> None:
    """A witness that lost a thread would report drops that never were."""
    sys.__excepthook__(
        failure.exc_type, failure.exc_value or failure.exc_type(), failure.exc_traceback
    )
    os._exit(1)


def observe(
    observer: Observer, on_snapshot: Callable[[], None] = lambda: None, period_s: float = 1.0
) -> None:
    """Runs from the first configuration to the last message, if one is to come.

    Prints a snapshot each `period_s`; `on_snapshot` follows.
    """
    observer.is_configured.wait()
    if not observer.topics:
        return
    while not observer.is_matched():
        time.sleep(0.05)
    observer.start_headset()
    while not observer.is_final.wait(timeout=period_s):
        print(json.dumps(observer.snapshot(final=False)), flush=True)
        on_snapshot()
    arrived, deadline_s = -1, 0.0
    while observer.awaits_more():
        if (count := observer.count) > arrived:
            arrived, deadline_s = count, time.monotonic() + _LAST_S
        elif time.monotonic() > deadline_s:
            break
        time.sleep(0.05)


if __name__ == "__main__":
    sys.exit(main())

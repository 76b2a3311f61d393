"""The ROS node of `ml2-receiver topics` and `devices`: what a receiver says of itself."""

import os
import threading
from collections import defaultdict
from collections.abc import Callable, Sequence
from contextlib import ExitStack

from rclpy.context import Context
from rclpy.exceptions import NameValidationException
from rclpy.qos import QoSProfile
from rclpy.validate_full_topic_name import validate_full_topic_name

from ml2_receiver.errors import NO_RECEIVER_HINT, RosError
from ml2_receiver.printable import printable
from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker

from .diagnostics import TYPE, Rows, read_diagnostics
from .faults import Faults

_DEPTH = 10
_LONGEST_SERVICE = "set_parameters_atomically"
# Any node can publish rows of more: the least recent receivers are forgotten.
_MOST_RECEIVERS, _MOST_PROCESSES = 64, 16  # the latter of one name


class DiagnosticsNode:
    """The node `ml2_tools`: keeps the last /diagnostics of each receiver. close() ends it.

    Raises:
        RosError: ROS does not start.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._rows: dict[str, Rows] = {}
        self._processes: defaultdict[str, set[str]] = defaultdict(set)
        self._closing = ExitStack()
        node = self._closing.enter_context(tool_node("ml2_tools"))
        self._context = node.context
        subscription = RawSubscription(
            TYPE, "/diagnostics", QoSProfile(depth=_DEPTH), self._diagnosed
        )
        self._closing.callback(RawTaker(node, [subscription], Faults().add).stop)

    def close(self) -> None:
        """Ends the node; nothing may be called after."""
        self._closing.close()

    @property
    def context(self) -> Context:
        """The context for more nodes of this process; it ends with this node."""
        return self._context

    def rows(
        self, receiver: str, timeout_s: float, when: Callable[[Rows], bool] = lambda _: True
    ) -> Rows:
        """The values by row ("session", "clock", and the topics), and the row's own words as
        "message"; waits for the first of which `when` is true.

        Args:
            receiver: as in its --name, or empty.

        Raises:
            RosError: this receiver says nothing, or not that.
        """
        with self._changed:
            if self._changed.wait_for(
                lambda: receiver in self._rows and when(self._rows[receiver]), timeout_s
            ):
                return self._rows[receiver]
            others = sorted(self._rows)
        if receiver in others:
            raise RosError(
                f"the receiver has not reported within {timeout_s:.0f} s what is awaited",
                hint="Is a headset connected? `ml2-receiver doctor` finds what is wrong.",
            )
        if others:
            names = ", ".join(f"--name {name}" if name else "no --name" for name in others)
            raise RosError(
                f"no such receiver in this ROS domain, but with {names}",
                hint="Call the command with the --name of the receiver.",
            )
        domain = os.environ.get("ROS_DOMAIN_ID", "0")
        raise RosError(f"no receiver in ROS domain {domain}", hint=NO_RECEIVER_HINT)

    def node_name(self, receiver: str, timeout_s: float) -> str:
        """Returns the full name of a receiver's node, of which its parameters and services are.

        Raises:
            RosError: as rows(), or another node says that it is the receiver.
        """
        usual = f"/{receiver}/ml2_receiver" if receiver else "/ml2_receiver"
        name = self.rows(receiver, timeout_s).get("session", {}).get("node", usual)
        try:
            validate_full_topic_name(f"{name}/{_LONGEST_SERVICE}")
        except NameValidationException as error:
            raise RosError(
                f"expected the name of a node in /diagnostics, found {printable(name, 100)}",
                hint="Another node seems to publish in the receiver's name.",
            ) from error
        return name

    def processes(self, receiver: str, count: int, timeout_s: float) -> Sequence[str]:
        """Returns the processes heard of with a receiver's name, such as "desk (pid 4711)".

        Waits for `count` of them; those of older receivers do not say it.
        """
        with self._changed:
            heard = self._processes[receiver]
            self._changed.wait_for(lambda: len(heard) >= count, timeout_s)
            return sorted(heard)

    def _diagnosed(self, payload: bytes) -> None:
        rows = {receiver: it.rows for receiver, it in read_diagnostics(payload).items()}
        with self._changed:
            for receiver, of_receiver in rows.items():
                self._rows.pop(receiver, None)  # the most recent one comes last
                self._rows[receiver] = of_receiver
                session, heard = of_receiver.get("session", {}), self._processes[receiver]
                if "host" in session and len(heard) < _MOST_PROCESSES:
                    heard.add(f"{session['host']} (pid {session.get('pid', '?')})")
            while len(self._rows) > _MOST_RECEIVERS:
                oldest = next(iter(self._rows))
                del self._rows[oldest], self._processes[oldest]
            self._changed.notify_all()

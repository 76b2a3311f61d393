"""The operations of the receiver that ROS services and parameters call."""

from collections.abc import Mapping
from typing import Protocol

from ..session.report import Report
from ..session.streams import Request
from ..wire.messages import Link


class ReceiverControl(Protocol):
    """The Server, as the node sees it. Thread-safe."""

    def report(self) -> Report | None:
        """Returns the report of the current session, or of the last one."""

    def paired(self) -> Mapping[str, str] | None:
        """Returns who may connect, as Access.paired()."""

    def begin(self) -> None:
        """Starts the streams, now or as soon as a headset is ready."""

    def pause(self) -> None:
        """Stops all streams until begin(); the headset stays connected."""

    def request(self, request: Request, link: Link | None = None, *, is_lazy: bool = False) -> None:
        """Requests other streams, values or `link`; streams with unchanged values continue.

        `is_lazy` lets streams rest that no output needs.
        """

    def demand(self, output: str, streams: Mapping[str, bool]) -> None:
        """Takes the streams that an output publishes now, each with whether it is needed.

        Returns at once; a Sink may call it.
        """

    def test_link(self) -> None:
        """Measures the link to the headset for about 2 s; report() has the result.

        Raises:
            LinkTestError: no headset is connected, or a test is in progress.
        """

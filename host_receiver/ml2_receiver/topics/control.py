"""The operations of the receiver that ROS services and parameters call."""

from typing import Protocol

from ..session.report import Report
from ..session.streams import Request
from ..transport.access import Protection


class Control(Protocol):
    """The Server, as the node sees it. Thread-safe."""

    def report(self) -> Report | None:
        """The session there is, or the last one."""

    def protection(self) -> Protection:
        """Returns who may connect."""

    def begin(self) -> None:
        """Lets the streams run, now or as soon as a headset is ready for it."""

    def pause(self) -> None:
        """Stops all streams until begin(); the headset stays connected."""

    def request(self, request: Request) -> None:
        """Asks for other streams or values; streams whose values stay go on undisturbed."""

    def test_link(self) -> None:
        """Tries what the link to the headset carries, for about 2 s; report() has the result.

        Raises:
            LinkTestError: no headset is connected, or it is being asked already.
        """

    def update(self) -> None:
        """Which streams are idle has changed."""

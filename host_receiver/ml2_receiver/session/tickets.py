"""The one-time tickets with which a device joins the lanes of its session."""

import secrets
from collections.abc import Iterable

from ..errors import ErrorCode, ProtocolError

_TOKEN_BYTES = 16


def new_token() -> str:
    """Returns 128 random bits in hexadecimal."""
    return secrets.token_hex(_TOKEN_BYTES)


class Tickets:
    """One ticket for each lane of a session, which can be used once.

    Attributes:
        by_lane: the tickets that WELCOME contains.
    """

    def __init__(self, lanes: Iterable[str]) -> None:
        self.by_lane = {lane: new_token() for lane in lanes}
        self._used: set[str] = set()

    def use(self, lane: str, ticket: str) -> None:
        """Uses the ticket of `lane`.

        Raises:
            ProtocolError: `ticket`: there is no such lane, or the ticket is wrong or was used.
        """
        expected = self.by_lane.get(lane)
        if expected is None:
            raise ProtocolError(ErrorCode.TICKET, f"no lane {lane!r} can be joined")
        if not secrets.compare_digest(expected.encode(), ticket.encode()):
            raise ProtocolError(ErrorCode.TICKET, f"wrong ticket for lane {lane!r}")
        if lane in self._used:
            raise ProtocolError(ErrorCode.TICKET, f"the ticket for lane {lane!r} is used")
        self._used.add(lane)

    def are_used(self, lanes: Iterable[str]) -> bool:
        """Returns True if the ticket of each of `lanes` was used."""
        return self._used.issuperset(lanes)

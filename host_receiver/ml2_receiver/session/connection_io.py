"""A connection's bytes and its place in the state machine, together."""

import time
from contextlib import suppress
from dataclasses import dataclass, field

from ..transport.transport import Transport
from ..wire.frame import FrameParser, Side
from .connection import Connection
from .context import Ending


@dataclass(eq=False)
class ConnectionIO:
    """The wire side of a Connection. Its reader alone receives, parses and closes.

    `abort_s` is when it is to be aborted, in monotonic time; None is never.
    """

    transport: Transport
    connection: Connection
    parser: FrameParser = field(default_factory=lambda: FrameParser(Side.DEVICE))
    abort_s: float | None = None
    is_aborted: bool = False

    def write(self, data: bytes) -> None:
        """Never waits for a peer: one that leaves a whole send buffer unread is cut off."""
        try:
            is_taken = self.transport.send(data)
        except OSError:
            return  # it has gone, as the reader will find
        if not is_taken:
            self.abort()

    def end(self, ending: Ending, linger_s: float) -> None:
        """Begins what Ending says."""
        if ending is Ending.ABORT:
            self.abort()
            return
        self.abort_s = time.monotonic() + linger_s
        with suppress(OSError):  # the peer may have gone
            if ending is Ending.DISCARD:
                self.transport.end_output()
            else:
                self.transport.end()

    def abort(self) -> None:
        self.is_aborted = True
        self.transport.abort()

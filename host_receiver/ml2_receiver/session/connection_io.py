"""The transport of a Connection."""

import time
from contextlib import suppress
from dataclasses import dataclass, field

from ..transport.transport import Transport
from ..wire.frame import FrameParser, Side
from .connection import Connection
from .context import Ending


@dataclass(eq=False)
class ConnectionIO:
    """The transport and the parser of a Connection.

    Only the reader thread of the connection receives, parses and closes. `abort_s` is the monotonic
    time at which the connection is aborted; None means never.
    """

    transport: Transport
    connection: Connection
    parser: FrameParser = field(default_factory=lambda: FrameParser(Side.DEVICE))
    abort_s: float | None = None
    is_aborted: bool = False

    def write(self, data: bytes) -> None:
        """Sends without waiting; aborts the connection if the send buffer is full."""
        try:
            is_sent = self.transport.send(data)
        except OSError:
            return  # the peer has disconnected, which the reader thread will notice
        if not is_sent:
            self.abort()

    def end(self, ending: Ending, linger_s: float) -> None:
        """Starts to close the connection as `ending` says; it is aborted after `linger_s`."""
        if ending is Ending.ABORT:
            self.abort()
            return
        self.abort_s = time.monotonic() + linger_s
        with suppress(OSError):  # the peer may have disconnected
            if ending is Ending.DISCARD:
                self.transport.end_output()
            else:
                self.transport.end()

    def abort(self) -> None:
        self.is_aborted = True
        self.transport.abort()

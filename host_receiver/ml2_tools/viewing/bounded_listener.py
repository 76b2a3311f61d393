"""A listening socket that goes on accepting, whatever its peers do."""

import socket
import struct
import threading
import time
from contextlib import suppress
from typing import Any

# A page opens six at a time. Each costs this process four file descriptors and three threads.
MOST_STRANGERS = 48
_POLL_S = 0.2
_PAUSE_S = 0.1
_CLOSING_S = 0.002


class BoundedListener(socket.socket):
    """A listener with a bounded number of accepted connections that have not shown the token.

    The oldest ones are closed for newer ones. accept() raises OSError only after close(); while the
    process has no file descriptor left, it waits.

    Args:
        listener: a listening socket; it becomes unusable.
        send_timeout_s: ends connections whose peer reads nothing for so long.
    """

    def __init__(self, listener: socket.socket, send_timeout_s: int) -> None:
        super().__init__(fileno=listener.detach())
        self.settimeout(_POLL_S)
        self._send_timeout = struct.pack("ll", send_timeout_s, 0)  # a struct timeval
        self._lock = threading.Lock()
        self._strangers: list[socket.socket] = []

    def accept(self) -> tuple[socket.socket, Any]:
        while True:
            self._make_room()
            try:
                accepted, address = super().accept()
                accepted.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, self._send_timeout)
            except TimeoutError:
                continue
            except OSError:
                if self._is_closed:
                    raise
                time.sleep(_PAUSE_S)
                continue
            with self._lock:
                self._strangers.append(accepted)
            if self._is_closed:
                self._disconnect(MOST_STRANGERS)
            return accepted, address

    def trust(self, accepted: socket.socket) -> None:
        """Counts a connection no more: it has shown the token. Thread-safe."""
        with self._lock, suppress(ValueError):
            self._strangers.remove(accepted)

    def close(self) -> None:
        """Listens no more, and ends the connections that have not shown the token."""
        super().close()
        self._disconnect(MOST_STRANGERS)

    @property
    def _is_closed(self) -> bool:
        return self.fileno() < 0

    def _make_room(self) -> None:
        while len(self._strangers) >= MOST_STRANGERS and not self._is_closed:
            self._disconnect(MOST_STRANGERS // 2)
            time.sleep(_CLOSING_S)
            with self._lock:
                self._strangers = [it for it in self._strangers if it.fileno() >= 0]

    def _disconnect(self, count: int) -> None:
        """Disconnects the oldest strangers; their threads then close their sockets."""
        with self._lock:
            for it in self._strangers[:count]:
                with suppress(OSError):
                    it.shutdown(socket.SHUT_RDWR)

"""Accepts connections on a socket that can be replaced while it listens."""

import socket
import threading
from collections.abc import Callable
from contextlib import suppress

from ..transport.listener import listen, peer_host, text

_PAUSE_S = 0.1


class Acceptor:
    """A thread that accepts connections from start() to stop().

    Args:
        listener: a socket from listen(); close() closes it.
        opened: takes an accepted socket with the peer's host and port, in the acceptor's thread;
            returns False if it does not want the socket, which is then closed.
        failed: is told why connections cannot be accepted, in the acceptor's thread.
    """

    def __init__(
        self,
        listener: socket.socket,
        opened: Callable[[socket.socket, str, int], bool],
        failed: Callable[[str], object],
    ) -> None:
        self._listener = listener
        self._opened, self._failed = opened, failed
        self._stopping = threading.Event()
        self.thread = threading.Thread(target=self._run, name="accept", daemon=True)

    @property
    def address(self) -> str:
        """The HOST:PORT that it listens on."""
        return text(self._listener.getsockname())

    def listen_on(self, address: tuple[str, int]) -> socket.socket:
        """Listens on another address and returns the new socket; accepted ones stay open.

        Calls must not overlap.

        Raises:
            ListenError: the address cannot be used. It then listens nowhere.
        """
        before = self._listener
        with suppress(OSError):  # a failed attempt has shut it down already
            before.shutdown(socket.SHUT_RDWR)  # wakes the thread and frees the port
        self._listener = listen(address)
        before.close()
        return self._listener

    def stop(self) -> None:
        """Lets the thread end; close() follows when it has ended."""
        self._stopping.set()
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Closes the socket."""
        self._listener.close()

    def _run(self) -> None:
        while not self._stopping.is_set():
            listener = self._listener
            try:
                accepted, address = listener.accept()
            except OSError as error:
                if not self._stopping.wait(_PAUSE_S) and listener is self._listener:
                    self._failed(f"cannot accept connections: {error}")
                continue
            if not self._opened(accepted, peer_host(address[0]), address[1]):
                accepted.close()

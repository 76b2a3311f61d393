"""A TCP proxy between headset and receiver that can be slow, and can cut every connection."""

from __future__ import annotations

import contextlib
import random
import socket
import threading
import time
from typing import Self

_CHUNK_BYTES = 64 * 1024


class Proxy:
    """Forwards connections from a local port to `target`; a context manager.

    Args:
        target: HOST:PORT.
        bytes_per_s: the limit for all connections towards the target together; None for no limit.
        jitter_s: the largest delay of a chunk towards the target; delays are evenly distributed.
        captures: True to keep the forwarded bytes.

    Attributes:
        captured: the forwarded bytes in the order of their chunks; empty unless `captures`.
    """

    def __init__(
        self,
        target: str,
        bytes_per_s: float | None = None,
        jitter_s: float = 0.0,
        *,
        captures: bool = False,
    ) -> None:
        self.captured = bytearray()
        self._captures = captures
        host, port = target.rsplit(":", 1)
        self._target = (host, int(port))
        self.limit(bytes_per_s)
        self._free_at_s = 0.0
        self._jitter_s = jitter_s
        self._lock = threading.Lock()
        self._is_up = threading.Event()
        self._is_up.set()
        self._sockets: set[socket.socket] = set()
        self._listener = socket.create_server(("127.0.0.1", 0))

    @property
    def address(self) -> str:
        """The address that the headset connects to."""
        host, port = self._listener.getsockname()
        return f"{host}:{port}"

    def __enter__(self) -> Self:
        self._accepting = threading.Thread(target=self._accept, daemon=True)
        self._accepting.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._accepting.join()
        self.cut()

    def limit(self, bytes_per_s: float | None) -> None:
        """Sets the limit for all connections towards the target together; None for no limit."""
        self._s_per_byte = 0.0 if bytes_per_s is None else 1 / bytes_per_s

    def cut(self) -> None:
        """Closes every connection, as a lost link does in the end; accepts new ones."""
        with self._lock:
            sockets, self._sockets = self._sockets, set()
        for cut in sockets:
            with contextlib.suppress(OSError):
                cut.shutdown(socket.SHUT_RDWR)
            cut.close()

    def take_down(self) -> None:
        """Stops forwarding without closing connections, as a lost link does at first."""
        self._is_up.clear()

    def bring_up(self) -> None:
        """Closes the earlier connections and forwards again."""
        self.cut()
        self._is_up.set()

    def _accept(self) -> None:
        while True:
            try:
                device, _ = self._listener.accept()
            except OSError:
                return
            device.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            try:
                receiver = socket.create_connection(self._target)
            except OSError:  # a headset looks for a receiver that has ended
                device.close()
                continue
            receiver.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with self._lock:
                self._sockets |= {device, receiver}
            for source, sink, slow in ((device, receiver, True), (receiver, device, False)):
                threading.Thread(
                    target=self._forward, args=(source, sink, slow), daemon=True
                ).start()

    def _forward(self, source: socket.socket, sink: socket.socket, slow: bool) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(_CHUNK_BYTES):
                self._is_up.wait()
                if slow:
                    self._wait_for(len(data))
                    time.sleep(random.uniform(0, self._jitter_s))
                if self._captures:
                    with self._lock:
                        self.captured += data
                sink.sendall(data)
            sink.shutdown(socket.SHUT_WR)

    def _wait_for(self, size: int) -> None:
        """Waits until the slow link, which all connections share, has sent `size` bytes."""
        with self._lock:
            now_s = time.monotonic()
            self._free_at_s = max(self._free_at_s, now_s) + size * self._s_per_byte
            pause_s = self._free_at_s - now_s
        if pause_s > 0:
            time.sleep(pause_s)

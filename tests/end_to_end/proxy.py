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
    """Forwards to `target` from a port of its own; a context manager.

    Args:
        target: HOST:PORT.
        bytes_per_s: of all connections towards the target together; None for no limit.
        jitter_s: what goes towards the target is delayed by up to this, evenly distributed.

    Attributes:
        captured: what was forwarded, in the order of its chunks; empty unless it `captures`.
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
        self._s_per_byte = 0.0 if bytes_per_s is None else 1 / bytes_per_s
        self._free_at_s = 0.0
        self._jitter_s = jitter_s
        self._lock = threading.Lock()
        self._carries = threading.Event()
        self._carries.set()
        self._sockets: set[socket.socket] = set()
        self._listener = socket.create_server(("127.0.0.1", 0))

    @property
    def address(self) -> str:
        """Where the headset connects to."""
        host, port = self._listener.getsockname()
        return f"{host}:{port}"

    def __enter__(self) -> Self:
        threading.Thread(target=self._accept, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self.cut()

    def cut(self) -> None:
        """Resets every connection, as a lost link does in the end; new ones are welcome."""
        with self._lock:
            sockets, self._sockets = self._sockets, set()
        for cut in sockets:
            with contextlib.suppress(OSError):
                cut.shutdown(socket.SHUT_RDWR)
            cut.close()

    def take_down(self) -> None:
        """Carries nothing from now on, and tells nobody, as a lost link does at first."""
        self._carries.clear()

    def bring_up(self) -> None:
        """Carries again; connections of before are reset."""
        self.cut()
        self._carries.set()

    def _accept(self) -> None:
        while True:
            try:
                device, _ = self._listener.accept()
            except OSError:
                return
            device.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            receiver = socket.create_connection(self._target)
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
                self._carries.wait()
                if slow:
                    self._wait_for(len(data))
                    time.sleep(random.uniform(0, self._jitter_s))
                if self._captures:
                    with self._lock:
                        self.captured += data
                sink.sendall(data)
            sink.shutdown(socket.SHUT_WR)

    def _wait_for(self, size: int) -> None:
        """Gives each chunk its place on the one slow link."""
        with self._lock:
            now_s = time.monotonic()
            self._free_at_s = max(self._free_at_s, now_s) + size * self._s_per_byte
            pause_s = self._free_at_s - now_s
        if pause_s > 0:
            time.sleep(pause_s)

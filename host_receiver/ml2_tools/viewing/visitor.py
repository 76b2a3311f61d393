"""Serves one browser, with at most two messages of each kind on their way to it."""

from __future__ import annotations

import json
import threading
import time
from collections import Counter
from collections.abc import Iterator

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import ServerConnection

from .live_view import LiveView
from .plots import SHOWN_S, UNITS
from .requests import RequestError, Seen, parse_request

_MOST_UNDER_WAY = 2
_PERIOD_S = 0.1
# The kinds of text messages, which a browser acknowledges like images.
_STATE, _SAMPLES = "state", "samples"


class Visitor:
    """One browser that has sent the token.

    serve() reads in the calling thread. A second thread sends: only it waits for a slow browser.
    """

    def __init__(self, connection: ServerConnection, view: LiveView) -> None:
        self._connection, self._view = connection, view
        self._shown: frozenset[str] = frozenset()
        self._under_way: Counter[str] = Counter()
        # The number of the newest image or state that was sent, and the count of plotted values.
        self._sent: Counter[str] = Counter()
        self._plotted: Counter[str] = Counter()
        self._next_samples_s = 0.0
        self._is_over = False

    def serve(self) -> None:
        """Returns when the connection has ended.

        Raises:
            RequestError: the browser sent an invalid message.
            ConnectionClosed: the connection broke.
        """
        sender = threading.Thread(target=self._send, name="view-sender")
        self._view.watch(self, self._shown)
        sender.start()
        try:
            for message in self._connection:
                self._take(message)
        finally:
            self._view.watch(self, None)
            self._is_over = True
            with self._view.changed:
                self._view.changed.notify_all()
            sender.join()

    def _take(self, message: str | bytes) -> None:
        request = parse_request(message, self._view.images)
        if not isinstance(request, Seen):
            self._shown = request.streams
            self._view.watch(self, request.streams)
            return
        with self._view.changed:
            if not self._under_way[request.name]:
                raise RequestError("a message was acknowledged that is not on its way")
            self._under_way[request.name] -= 1
            self._view.changed.notify_all()

    def _send(self) -> None:
        try:
            plots = [{"name": name, "unit": unit} for name, unit in UNITS.items()]
            hello = {"type": "hello", "plots": plots, "shown_s": SHOWN_S}
            self._connection.send(json.dumps(hello | {"images": list(self._view.images)}))
            while not self._is_over:
                has_sent = False
                for name, message in self._messages():
                    with self._view.changed:
                        self._under_way[name] += 1
                    self._connection.send(message)
                    has_sent = True
                if not has_sent:
                    with self._view.changed:
                        self._view.changed.wait(_PERIOD_S)
        except ConnectionClosed:
            return

    def _messages(self) -> Iterator[tuple[str, bytes | str]]:
        """Yields what is new and may be sent, each with its kind: a stream, or one of text."""
        for stream in self._shown:
            image = self._view.images[stream]
            if self._may_send(stream) and image.number not in (0, self._sent[stream]):
                self._sent[stream], message = image.encoded()
                yield stream, message
        number, state = self._view.state
        if self._may_send(_STATE) and number != self._sent[_STATE]:
            self._sent[_STATE] = number
            yield _STATE, state
        if self._may_send(_SAMPLES) and time.monotonic() >= self._next_samples_s:
            self._next_samples_s = time.monotonic() + _PERIOD_S
            if (samples := self._samples()) is not None:
                yield _SAMPLES, samples

    def _may_send(self, kind: str) -> bool:
        return self._under_way[kind] < _MOST_UNDER_WAY

    def _samples(self) -> str | None:
        plots = {}
        for name, series in self._view.series.items():
            self._plotted[name], new = series.since(self._plotted[name])
            if new:
                plots[name] = new
        samples = {"type": _SAMPLES, "now_s": time.time(), "plots": plots}
        return json.dumps(samples) if plots else None

"""Serves one browser, with at most two messages of each kind on their way to it."""

import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator

from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.sync.server import ServerConnection

from ml2_receiver.json_text import json_text
from ml2_receiver.printable import printable
from ml2_receiver.recording.message_definitions import DEFINITIONS

from .cloud import CLOUD
from .fields import fields_of
from .full_image import full_name
from .log import LOG
from .newest_image import framed
from .plots import SHOWN_S, UNITS
from .requests import (
    Backend,
    BackendRequest,
    Pixel,
    RequestError,
    Seen,
    Show,
    Snapshot,
    parse_request,
)
from .scene import SCENE
from .snapshot import SNAPSHOT, snapshot_of
from .view import View

_MOST_UNDER_WAY = 2
# The limit of RFC 6455 for the reason of a close, which follows its code.
_MOST_REASON_BYTES = 123
# A page asks for one change of a section, and one call of a service, at a time.
_MOST_ASKED = 64
_PERIOD_S = 0.1
# The kinds of text messages that a browser acknowledges like images.
_STATE, _SAMPLES = "state", "samples"


class BrowserConnection:
    """One browser that has sent the token.

    serve() reads in the calling thread. A second thread sends: only it waits for a slow browser.
    An exception that nobody foresaw closes the connection, with a reason for the page, which
    connects again.
    """

    def __init__(self, connection: ServerConnection, view: View, backend: Backend) -> None:
        self._connection, self._view, self._backend = connection, view, backend
        self._shown: frozenset[str] = frozenset()
        self._under_way: Counter[str] = Counter()
        # The number of the newest image or state that was sent, and the count of plotted values.
        self._sent: Counter[str] = Counter()
        self._plotted: Counter[str] = Counter()
        self._next_samples_s = 0.0
        # The number of requests without a sent answer, and the answers to send.
        self._asked = 0
        self._answers: deque[str | bytes] = deque()
        self._is_over = False

    def serve(self) -> None:
        """Returns when the connection has ended.

        Raises:
            RequestError: the browser sent an invalid message.
            ConnectionClosed: the connection broke.
        """
        sender = threading.Thread(target=self._send, name="view-sender")
        try:
            self._view.watch(self, self._shown)
            sender.start()
            for message in self._connection:
                self._take(message)
        except (RequestError, ConnectionClosed):
            raise
        except Exception as error:
            self._fail(error)
        finally:
            self._is_over = True
            with self._view.changed:
                self._view.changed.notify_all()
            self._leave()
            if sender.ident is not None:
                sender.join()

    def _leave(self) -> None:
        try:
            self._view.watch(self, None)
        except Exception as error:
            self._fail(error)

    def _fail(self, error: Exception) -> None:
        self._view.faults.add("a connection of a browser", error)
        self._connection.close(CloseCode.INTERNAL_ERROR, close_reason(error))

    def _take(self, message: str | bytes) -> None:
        match parse_request(message, self._view.offered, self._backend.allowed):
            case Show(streams):
                for name in self._shown - streams:  # its values may begin anew
                    self._plotted.pop(name, None)
                self._shown = streams
                self._view.watch(self, streams)
            case Seen(name):
                self._acknowledge(name)
            case Pixel(stream, column, row):
                self._tell_pixel(stream, column, row)
            case Snapshot():
                self._expect_answer()
                self._answer(framed(SNAPSHOT, 0, snapshot_of(self._view, self._shown)))
            case request:
                self._ask(request)

    def _acknowledge(self, name: str) -> None:
        with self._view.changed:
            if not self._under_way[name]:
                raise RequestError("a message was acknowledged that is not on its way")
            self._under_way[name] -= 1
            self._view.changed.notify_all()

    def _ask(self, request: BackendRequest) -> None:
        self._expect_answer()
        self._backend.submit(request, lambda answer: self._answer(answer.message()))

    def _tell_pixel(self, stream: str, column: int, row: int) -> None:
        if (image := self._view.full.get(full_name(stream))) is None:
            raise RequestError("expected a stream with images")
        self._expect_answer()
        pixel = {"type": "pixel", "at": [column, row], "value": image.pixel(column, row)}
        self._answer(json_text(pixel))

    def _expect_answer(self) -> None:
        with self._view.changed:
            if self._asked == _MOST_ASKED:
                raise RequestError("too many requests wait for an answer")
            self._asked += 1

    def _answer(self, message: str | bytes) -> None:
        with self._view.changed:
            self._answers.append(message)
            self._view.changed.notify_all()

    def _send(self) -> None:
        try:
            self._send_until_over()
        except ConnectionClosed:
            return
        except Exception as error:
            self._fail(error)

    def _send_until_over(self) -> None:
        self._connection.send(self._hello())
        while not self._is_over:
            has_sent = False
            # An answer follows the values that its request changed. Those of a later answer may
            # not be among the messages of this turn.
            answers = len(self._answers)
            for name, message in self._messages():
                with self._view.changed:
                    self._under_way[name] += 1
                self._connection.send(message)
                has_sent = True
            for _ in range(answers):
                self._connection.send(self._answers.popleft())
                has_sent = True
                with self._view.changed:
                    self._asked -= 1
            if not has_sent:
                with self._view.changed:
                    self._view.changed.wait(_PERIOD_S)

    def _hello(self) -> str:
        hello = {
            "type": "hello",
            "images": self._view.streams,
            "plots": [{"name": name, "unit": UNITS[name]} for name in self._view.series],
            "shown_s": SHOWN_S,
            "fields": {type: list(fields) for type in DEFINITIONS if (fields := fields_of(type))},
            **self._backend.described(),
        }
        return json_text(hello)

    def _messages(self) -> Iterator[tuple[str, bytes | str]]:
        """Yields what is new and may be sent, each with its kind: a stream, or one of text."""
        for kind, newest in self._sources():
            if not self._may_send(kind):
                continue
            number, message = newest()
            if number not in (0, self._sent[kind]):
                self._sent[kind] = number
                yield kind, message
        if self._may_send(_SAMPLES) and time.monotonic() >= self._next_samples_s:
            self._next_samples_s = time.monotonic() + _PERIOD_S
            if (samples := self._samples()) is not None:
                yield _SAMPLES, samples

    def _sources(self) -> Iterator[tuple[str, Callable[[], tuple[int, bytes | str]]]]:
        """Yields each kind of message with the function for the newest one and its number."""
        view, shown = self._view, self._shown
        for stream in shown & view.images.keys():
            yield stream, view.images[stream].encoded
        if SCENE in shown:
            yield SCENE, lambda: view.scene.newest(view.now_s)
        if CLOUD in shown:
            yield CLOUD, lambda: view.cloud.encoded(view.images["depth"], view.images["color"])
        yield _STATE, lambda: view.state
        yield LOG, lambda: view.log.newest
        yield from self._backend.sources()

    def _may_send(self, kind: str) -> bool:
        return self._under_way[kind] < _MOST_UNDER_WAY

    def _samples(self) -> str | None:
        plots = {}
        for name, series in list(self._view.series.items()):
            if name not in UNITS and name not in self._shown:
                continue
            self._plotted[name], new = series.since(self._plotted[name])
            if new:
                plots[name] = new
        samples = {"type": _SAMPLES, "now_s": self._view.now_s, "plots": plots}
        return json_text(samples) if plots else None


def close_reason(error: Exception) -> str:
    """Returns an error in the bytes that a WebSocket has for the reason of its end."""
    words = str(error) if isinstance(error, RequestError) else f"internal error: {error!r}"
    return printable(words).encode()[:_MOST_REASON_BYTES].decode(errors="ignore")

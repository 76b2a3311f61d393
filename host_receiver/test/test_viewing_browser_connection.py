"""The order of the messages that a browser gets."""

import json
import queue
import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Any, cast

import pytest

pytest.importorskip("websockets", reason="websockets is not installed")

from websockets.sync.server import ServerConnection

from ml2_tools.viewing.browser_connection import BrowserConnection
from ml2_tools.viewing.requests import AllowedRequests, BackendRequest, Newest, Outcome
from ml2_tools.viewing.section_forms import SERVICES
from ml2_tools.viewing.view import Source, View
from waiting import LIMIT_S


class Silent:
    """A source without messages."""

    def start(self, view: View) -> None:
        pass

    def close(self) -> None:
        pass

    def now_s(self) -> float:
        return 0.0


class Page:
    """The connection of a browser that calls one service."""

    def __init__(self) -> None:
        self.received: queue.Queue[dict[str, Any]] = queue.Queue()
        self.is_closed = threading.Event()

    def __iter__(self) -> Iterator[str]:
        yield json.dumps({"call": "stop"})
        self.is_closed.wait()

    def send(self, message: str) -> None:
        self.received.put(json.loads(message))


class ChangedMeanwhile:
    """Carries out a request just after the connection has looked for what is in force."""

    allowed = AllowedRequests(services=SERVICES)

    def __init__(self) -> None:
        self._in_force: Newest = 1, json.dumps({"type": "settings", "values": "old"})
        self._answered: Callable[[Outcome], None] | None = None

    def described(self) -> dict[str, Any]:
        return {}

    def sources(self) -> Iterable[tuple[str, Callable[[], Newest]]]:
        return [("settings", self._newest)]

    def submit(self, request: BackendRequest, answered: Callable[[Outcome], None]) -> None:
        self._answered = answered

    def _newest(self) -> Newest:
        found = self._in_force
        if self._answered is not None:
            self._in_force = 2, json.dumps({"type": "settings", "values": "new"})
            self._answered(Outcome("stop", True, ""))
            self._answered = None
        return found


def test_the_values_in_force_come_before_the_answer_to_their_change() -> None:
    page = Page()
    view = View(cast(Source, Silent()), "", with_eyes=False)
    connection = BrowserConnection(cast(ServerConnection, page), view, ChangedMeanwhile())
    reader = threading.Thread(target=connection.serve)
    reader.start()
    kinds: list[str] = []
    while kinds[-1:] != ["answer"]:
        message = page.received.get(timeout=LIMIT_S)
        kinds.append(message.get("values", message["type"]))
    page.is_closed.set()
    reader.join()
    assert kinds[-2:] == ["new", "answer"]

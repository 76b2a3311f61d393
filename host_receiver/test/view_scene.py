"""The real server of `ml2-receiver view` with a source of which a test says what it brings."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from ml2_receiver.transport.listener import listen
from ml2_tools.monitoring.topic_table import Rows
from ml2_tools.viewing.access import Token
from ml2_tools.viewing.losses import RecentLosses
from ml2_tools.viewing.requests import AllowedRequests, BackendRequest, Newest, Outcome
from ml2_tools.viewing.section_forms import receiver_state
from ml2_tools.viewing.server import ViewServer
from ml2_tools.viewing.state import Levels, state_of
from ml2_tools.viewing.subscription import Subscription
from ml2_tools.viewing.view import View
from viewing_browser import Browser
from waiting import await_true

WORLD = "/magic_leap2/world_left/image_raw"
DEPTH = "/magic_leap2/depth/image_raw"
IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
COUNTS = {"gaps": "0", "unpublished": "0", "message": "running"}
ROWS: dict[str, Mapping[str, str]] = {
    "session": {
        "message": "head: connected",
        "headset": "head",
        "state": "connected",
        "state.world_left": "running",
        "state.depth": "running",
    },
    WORLD: {"stream": "world_left", "type": IMAGE, "rate_hz": "14.9", **COUNTS},
}
WORLD_JPEG, DEPTH_RVL = f"{WORLD}/compressed", f"{DEPTH}/compressedDepth"
COMPRESSED_ROWS: dict[str, Mapping[str, str]] = {
    "session": ROWS["session"],
    WORLD_JPEG: {"stream": "world_left", "type": COMPRESSED, **COUNTS},
    DEPTH_RVL: {"stream": "depth", "type": COMPRESSED, **COUNTS},
}


class Scripted:
    """A Source, and a Backend that takes nothing."""

    allowed = AllowedRequests()

    def __init__(self) -> None:
        self.subscriptions: list[Subscription] = []
        self.clock_s = 1.0
        self._losses = RecentLosses()

    def start(self, view: View) -> None:
        self._view = view

    def close(self) -> None:
        pass

    def now_s(self) -> float:
        return self.clock_s

    def unix_s(self, at_s: float) -> float:
        return at_s

    def add(self, subscription: Subscription) -> None:
        self.subscriptions.append(subscription)

    def remove(self, subscription: Subscription) -> None:
        self.subscriptions.remove(subscription)

    def state(self, rows: Rows, levels: Levels, modes: Mapping[str, str], battery: str) -> Any:
        recent = self._losses.count(rows, self.clock_s)
        return state_of(rows, levels, modes, battery, recent) | {"doing": receiver_state(rows)}

    def described(self) -> dict[str, Any]:
        return {"controls": []}

    def sources(self) -> Iterable[tuple[str, Callable[[], Newest]]]:
        return []

    def submit(self, request: BackendRequest, answered: Callable[[Outcome], None]) -> None:
        raise AssertionError(request)

    def report(self, rows: Rows) -> None:
        self._view.report(rows, dict.fromkeys(rows, 0))

    def bring(self, topic: str, payload: bytes, count: int = 1) -> None:
        """Brings a message, as soon as the view has asked so many times for the topic."""
        await_true(lambda: sum(it.topic == topic for it in list(self.subscriptions)) >= count)
        for subscription in list(self.subscriptions):
            if subscription.topic == topic:
                subscription.take(payload, self.now_s())


class Page:
    """The server's address, token, view and source."""

    def __init__(self, url: str, token: str, view: View, source: Scripted) -> None:
        self.url, self.token, self.view, self.source = url, token, view, source

    def browser(self) -> Browser:
        return Browser(self.url, self.token)


@contextmanager
def serving(rows: Rows) -> Iterator[Page]:
    source, token = Scripted(), Token()
    view = View(source, "", with_eyes=False)
    source.report(rows)
    listener = listen(("127.0.0.1", 0))
    url = f"http://127.0.0.1:{listener.getsockname()[1]}"
    server = ViewServer(listener, view, source, token)
    try:
        yield Page(url, token.text, view, source)
    finally:
        server.close()
        view.close()

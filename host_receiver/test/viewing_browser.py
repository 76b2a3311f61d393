"""A browser that shows `ml2-receiver view`, without a screen."""

import json
import struct
from contextlib import ExitStack, suppress
from typing import Any, NamedTuple, Self

import cv2
import numpy as np
from numpy.typing import NDArray
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Origin

from ros_processes import Child
from waiting import LIMIT_S


class View(Child):
    """`ml2-receiver view`; `url` and `token` are what it prints."""

    def __init__(self, *options: str) -> None:
        super().__init__("-m", "ml2_receiver", "view", "--no-browser", *options)
        self.url, self.token = self.line().removeprefix("open ").split("/#")


class Picture(NamedTuple):
    stream: str
    far_m: float
    pixels: NDArray[Any]


class Browser:
    """One connection of the page.

    Args:
        token: None sends none.
    """

    def __init__(self, url: str, token: str | None) -> None:
        address = f"{url.replace('http', 'ws', 1)}/live"
        self._open = ExitStack()
        self.connection = self._open.enter_context(
            connect(address, origin=Origin(url), compression=None, open_timeout=LIMIT_S)
        )
        if token is not None:
            self.say(token=token)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def say(self, **message: Any) -> None:
        self.connection.send(json.dumps(message))

    def next(
        self, *, acknowledges: bool = True, timeout_s: float = LIMIT_S
    ) -> dict[str, Any] | Picture:
        """The next message: JSON or an image."""
        message = self.connection.recv(timeout_s)
        found: dict[str, Any] | Picture = (
            json.loads(message) if isinstance(message, str) else picture(message)
        )
        kind = found.stream if isinstance(found, Picture) else found.get("stream", found["type"])
        if acknowledges and kind not in ("hello", "answer", "pixel"):
            self.say(seen=kind)
        return found

    def sent(self) -> list[dict[str, Any] | Picture]:
        """All that was sent until now and not read yet, which is not acknowledged."""
        assert self.connection.ping().wait(LIMIT_S)
        found: list[dict[str, Any] | Picture] = []
        with suppress(TimeoutError):
            while True:
                found.append(self.next(acknowledges=False, timeout_s=0))
        return found

    def text(self, type: str) -> dict[str, Any]:
        """The next JSON of this type; fails when a request fails meanwhile."""
        while True:
            found = self.next()
            if not isinstance(found, Picture):
                if found["type"] == type:
                    return found
                assert found["type"] != "answer" or found["is_done"], found

    def picture(self) -> Picture:
        while True:
            if isinstance(found := self.next(), Picture):
                return found

    def end(self) -> tuple[int, str]:
        """The code and the reason with which the server closes the connection."""
        with suppress(ConnectionClosed):
            while True:
                self.connection.recv(LIMIT_S)
        assert self.connection.close_code is not None
        return self.connection.close_code, self.connection.close_reason or ""


def picture(message: bytes) -> Picture:
    """Reads an image as the page does."""
    end = 1 + message[0]
    (far_m,) = struct.unpack_from("<f", message, end)
    data = np.frombuffer(message, np.uint8, offset=end + 4)
    return Picture(message[1:end].decode(), far_m, cv2.imdecode(data, cv2.IMREAD_UNCHANGED))

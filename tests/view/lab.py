"""A simulated headset, a receiver and `ml2-receiver view` as processes."""

import contextlib
import json
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import rclpy
from playwright.sync_api import Browser, Page, ViewportSize
from rclpy.context import Context
from rclpy.node import Node

from ml2_receiver.ros.context import end_node
from processes import (
    RECEIVER,
    headset_command,
    isolated_environment,
    line_with,
    listening_address,
    process,
    receive_command,
)
from simulation import SMALL, compressed_config
from waiting import LIMIT_S

# One camera of each kind, so that two cores carry them and a browser.
IMAGES = ("color", "depth", "world_left", "eye_nasal_left")
# A common laptop's.
SCREEN = ViewportSize(width=1366, height=768)
LIMIT_MS = 1000 * LIMIT_S
_OFF = ("world_center", "world_right", "eye_nasal_right", "eye_temple_left", "eye_temple_right")


@dataclass(frozen=True)
class Lab:
    """The running processes.

    Attributes:
        address: the address of the page, with its secret.
        folder: the folder in which the receiver was started.
        environment: the environment of programs that reach the receiver.
    """

    address: str
    folder: Path
    environment: dict[str, str]

    @property
    def origin(self) -> str:
        return self.address.partition("/#")[0]

    @contextlib.contextmanager
    def node(self, name: str) -> Iterator[Node]:
        """Another program's node in the ROS domain of the processes."""
        context = Context()
        rclpy.init(context=context, domain_id=int(self.environment["ROS_DOMAIN_ID"]))
        node = rclpy.create_node(name, context=context)
        try:
            yield node
        finally:
            end_node(node)


def new_page(browser: Browser, color_scheme: Literal["dark", "light"] | None = None) -> Page:
    """An empty page in a context of its own, which the caller closes."""
    context = browser.new_context(viewport=SCREEN, color_scheme=color_scheme)
    context.set_default_timeout(LIMIT_MS)
    return context.new_page()


class SentMessages:
    """Messages of a page to the server; on a busy machine, it may send them on a new connection."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._messages: list[Any] = []
        page.on("websocket", lambda it: it.on("framesent", self._add))

    def _add(self, message: str | bytes) -> None:
        self._messages.append(json.loads(message))

    @contextlib.contextmanager
    def expected(self, is_expected: Callable[[Any], bool]) -> Iterator[None]:
        """Waits, when left, for such a message; the test's time limit ends an endless wait."""
        self._messages.clear()
        yield
        while not any(map(is_expected, self._messages)):
            self._page.wait_for_timeout(50)


def written_config(folder: Path, color_hz: int = 30, depth_hz: int = 30) -> Path:
    config = folder / "config.yaml"
    changes: dict[str, dict[str, Any]] = {camera: {"enabled": False} for camera in _OFF}
    changes["picture_center"] = SMALL | {"update_rate": color_hz}
    changes["depth_center"] = {"update_rate": depth_hz}
    config.write_text(compressed_config(**changes))
    return config


@contextlib.contextmanager
def running_lab(folder: Path) -> Iterator[Lab]:
    """Starts the processes, with their logs in `folder`, and ends them."""
    config = written_config(folder, color_hz=15, depth_hz=5)
    environment = isolated_environment()
    with contextlib.ExitStack() as stack:

        def start(name: str, command: list[str | Path]) -> subprocess.Popen[str]:
            return stack.enter_context(process(command, environment, folder / f"{name}.log"))

        started_in = ["env", f"--chdir={folder}"]
        receiver = start("receiver", [*started_in, *receive_command(config, "127.0.0.1:0")])
        start("headset", headset_command(listening_address(receiver)))
        view = start("view", [RECEIVER, "view", "--no-browser", "--eyes"])
        yield Lab(line_with(view, "open ").split()[1], folder, environment)

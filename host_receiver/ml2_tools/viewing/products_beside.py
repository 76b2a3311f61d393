"""Runs `ml2-receiver products` beside the page, while a browser wants it."""

import subprocess
import sys

from ml2_receiver.errors import ReceiverError
from ml2_receiver.json_text import json_text

from .requests import Newest
from .state import topic_prefix
from .view import View

_PATIENCE_S = 5.0
# Services that browsers may call in addition to the receiver's own.
PRODUCTS = frozenset(("start_products", "stop_products"))


class ProductsBeside:
    """`ml2-receiver products` of one receiver as a process. Used by one thread, but newest.

    Args:
        view: knows the prefix of the topics.
        name: the receiver's --name, or empty.
    """

    def __init__(self, view: View, name: str) -> None:
        self._view, self._name = view, name
        self._process: subprocess.Popen[bytes] | None = None
        self._newest: Newest = 0, ""

    @property
    def newest(self) -> Newest:
        """The number of the newest message, from 1, and the message: whether it runs."""
        return self._newest

    def begin(self) -> None:
        """Starts the process, unless it runs.

        Raises:
            ReceiverError: the receiver has not reported its topics yet.
        """
        if self._process is not None:
            return
        if (prefix := topic_prefix(self._view.rows)) is None:
            raise ReceiverError("the receiver has not reported its topics yet")
        command = [sys.executable, "-P", "-m", "ml2_receiver", "products"]
        if self._name:
            prefix = prefix.removeprefix(f"/{self._name}")
            command += ["--name", self._name]
        self._process = subprocess.Popen([*command, "--prefix", prefix])

    def end(self) -> None:
        """Ends the process that runs."""
        if (process := self._process) is None:
            return
        process.terminate()
        try:
            process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        self._process = None

    def look(self) -> None:
        """Brings newest up to date; the process may have ended by itself."""
        if self._process is not None and self._process.poll() is not None:
            self._process = None
        message = json_text({"type": "products", "is_on": self._process is not None})
        if message != self._newest[1]:
            self._newest = self._newest[0] + 1, message

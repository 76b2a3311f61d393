"""The last word of an app on a topic, which the receiver publishes when the app falls silent."""

import threading
import time

from ..errors import PublishError
from .sink import Publish, refuse


class Will:
    """A message that is published once when a channel is silent for `silent_s`, or ends.

    It is published again only after another message. A thread of its own waits for silence, from
    the first message until close(). Thread-safe.

    Attributes:
        published: how often it was published.
    """

    def __init__(self, topic: str, message: bytes, silent_s: float) -> None:
        self.published = 0
        self.text = (
            f"{topic} fell silent for {silent_s * 1000:.0f} ms or ended: its will is published"
        )
        self._topic, self._message, self._silent_s = topic, message, silent_s
        self._changed = threading.Condition()
        self._publish: Publish = refuse
        self._due_s: float | None = None
        self._thread: threading.Thread | None = None
        self._is_over = False

    def publish(self, publish: Publish, payload: bytearray) -> None:
        """Publishes a message of the channel, after which silence begins.

        Raises:
            PublishError: as `publish` does, and after close(), since the will is the last word.
        """
        with self._changed:
            if self._is_over:
                raise PublishError(f"{self._topic} has ended with its will")
            is_new = self._due_s is None
            self._publish = publish
            self._due_s = time.monotonic() + self._silent_s
            if self._thread is None:
                self._thread = threading.Thread(target=self._wait, name="will", daemon=True)
                self._thread.start()
            elif is_new:
                self._changed.notify()
            publish(payload)

    def _wait(self) -> None:
        with self._changed:
            while not self._is_over:
                if self._due_s is None:
                    self._changed.wait()
                elif (left_s := self._due_s - time.monotonic()) > 0:
                    self._changed.wait(left_s)
                else:
                    self._say()

    def close(self) -> None:
        """Ends the channel, which publishes the will if it is due."""
        with self._changed:
            self._say()
            self._is_over = True
            self._changed.notify()

    def _say(self) -> None:
        if self._due_s is None:
            return
        self._due_s = None
        try:
            self._publish(bytearray(self._message))
        except PublishError:
            return
        self.published += 1

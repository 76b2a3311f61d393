"""Keeps the newest image of a stream, and encodes it at most once."""

import struct
import threading
import time
from typing import Any

from ml2_receiver.json_text import json_text
from ml2_receiver.printable import printable

from ..bags.decoding import decoder
from .preview import Preview, preview_of

_MOST_HZ = 15
# An image that is early by this share of a period is taken, so that 30 Hz become 15 and not 10.
_EARLY = 0.25
_FAR_M = struct.Struct("<f")


# The number of an image, from 1, its type and its CDR; both are empty without one.
type Newest = tuple[int, str, bytes]


class NewestImage:
    """The newest image of a stream, encoded at most 15 times per second. Thread-safe.

    Args:
        name: the name of its messages for browsers.
    """

    def __init__(self, stream: str, name: str = "") -> None:
        self._is_distance, self._name = stream == "depth", name or stream
        self._taking, self._encoding = threading.Lock(), threading.Lock()
        self._newest: Newest = 0, "", b""
        self._next_s = 0.0
        self._encoded: tuple[int, bytes | str] = 0, b""

    _most_hz: float = _MOST_HZ

    def _jpeg_of(self, message: Any, is_distance: bool) -> Preview:
        return preview_of(message, is_distance)

    @property
    def newest(self) -> Newest:
        """The number of the newest image, from 1, its type and its CDR; empty without one."""
        return self._newest

    def take(self, type: str, payload: bytes) -> bool:
        """Takes a message's CDR; returns False if it will not be encoded yet."""
        with self._taking:
            self._newest = self._newest[0] + 1, type, payload
        return self._is_due()

    def forget(self) -> None:
        """Forgets the image: the next one may be an older one."""
        with self._taking:
            self._newest = self._newest[0] + 1, "", b""

    def encoded(self) -> tuple[int, bytes | str]:
        """Returns number and message for browsers of the newest image, or of one just before.

        The message is bytes: the length of the stream's name, the name, the end of the colour scale
        in metres as a float32, and a JPEG. Of an image that cannot be shown it is JSON that says
        why; the reason is empty after forget().
        """
        with self._encoding:
            number, type, payload = self._newest
            if number != self._encoded[0] and self._is_due():
                self._next_s = max(self._next_s, time.monotonic()) + 1 / self._most_hz
                self._encoded = number, self._encode(type, payload)
            return self._encoded

    def _is_due(self) -> bool:
        return time.monotonic() >= self._next_s - _EARLY / self._most_hz

    def _encode(self, type: str, payload: bytes) -> bytes | str:
        if not type:
            return json_text({"type": "image", "stream": self._name, "reason": ""})
        try:
            message = decoder(type)(payload)
            jpeg, far_m = self._jpeg_of(message, self._is_distance)
        except ValueError as error:
            return json_text(
                {"type": "image", "stream": self._name, "reason": printable(str(error))}
            )
        return framed(self._name, far_m, jpeg)


def framed(name: str, far_m: float, data: bytes) -> bytes:
    """Returns the message of an image for browsers; encoded() says what is in it."""
    encoded = name.encode()
    return bytes([len(encoded)]) + encoded + _FAR_M.pack(far_m) + data

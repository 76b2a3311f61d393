"""Keeps the newest image of a stream, and encodes it at most once."""

from __future__ import annotations

import json
import struct
import threading
import time

from rclpy.serialization import deserialize_message

from ml2_receiver.topics.message_types import message_class

from .preview import preview_of

_MOST_HZ = 15
# An image that is early by this share of a period is taken, so that 30 Hz become 15 and not 10.
_EARLY = 0.25
_FAR_M = struct.Struct("<f")


class NewestImage:
    """The newest image of a stream, of at most 15 images per second. Thread-safe."""

    def __init__(self, stream: str) -> None:
        self._stream = stream
        self._taking, self._encoding = threading.Lock(), threading.Lock()
        self._newest: tuple[int, str, bytes] = 0, "", b""
        self._next_s = 0.0
        self._encoded: tuple[int, bytes | str] = 0, b""

    @property
    def number(self) -> int:
        """The number of the newest image, counted from 1; 0 before the first."""
        return self._newest[0]

    @property
    def newest(self) -> tuple[int, str, bytes]:
        """The number of the newest image, its type and its CDR."""
        return self._newest

    def take(self, type: str, payload: bytes) -> bool:
        """Takes a message's CDR; returns False if the image comes too early and is left out."""
        now_s = time.monotonic()
        with self._taking:
            if now_s < self._next_s - _EARLY / _MOST_HZ:
                return False
            self._next_s = max(self._next_s, now_s) + 1 / _MOST_HZ
            self._newest = self._newest[0] + 1, type, payload
        return True

    def encoded(self) -> tuple[int, bytes | str]:
        """Returns the number and the message of the newest image for browsers.

        The message is bytes: the length of the stream's name, the name, the end of the colour scale
        in metres as a float32, and a JPEG. Of an image that cannot be shown it is JSON that says
        why.
        """
        with self._encoding:
            number, type, payload = self._newest
            if number != self._encoded[0]:
                self._encoded = number, self._encode(type, payload)
            return self._encoded

    def _encode(self, type: str, payload: bytes) -> bytes | str:
        try:
            message = deserialize_message(payload, message_class(type))
            jpeg, far_m = preview_of(message, is_distance=self._stream == "depth")
        # rclpy raises RuntimeError for a payload that is not of the type.
        except (ValueError, RuntimeError) as error:
            return json.dumps({"type": "image", "stream": self._stream, "reason": str(error)})
        return framed(self._stream, far_m, jpeg)


def framed(name: str, far_m: float, data: bytes) -> bytes:
    """Returns the message of an image for browsers; encoded() says what is in it."""
    encoded = name.encode()
    return bytes([len(encoded)]) + encoded + _FAR_M.pack(far_m) + data

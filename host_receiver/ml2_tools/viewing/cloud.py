"""Makes the points of the newest depth image, for the 3D view."""

from __future__ import annotations

import math
import threading
import time

import numpy as np

from ml2_receiver.topics.stamps import header_stamp_ns

from ..bags.decoding import decoder
from ..geometry.lens import Floats
from ..images.pixels import pixels_of
from ..products.points import points_of
from .newest_image import NewestImage, framed
from .scene import Scene

CLOUD = "cloud"
_DEPTH = "depth"
_MOST_HZ = 5
_MOST_POINTS = 5000


class Cloud:
    """The points of the newest depth image in the world frame, at most 5000. Thread-safe."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._lock = threading.Lock()
        self._used = 0
        self._next_s = 0.0
        self._encoded: tuple[int, bytes] = 0, b""

    def encoded(self, depth: NewestImage) -> tuple[int, bytes]:
        """Returns the number of the cloud, from 1, and its message for browsers; 0 before it.

        The message is that of an image, with x, y and z of each point as float32 instead of a JPEG.
        """
        with self._lock:
            now_s = time.monotonic()
            number, type, payload = depth.newest
            if number not in (0, self._used) and now_s >= self._next_s:
                self._used, self._next_s = number, now_s + 1 / _MOST_HZ
                points = self._points(type, payload) if type else None
                if points is not None:
                    self._encoded = self._encoded[0] + 1, framed(CLOUD, 0, points.tobytes())
            return self._encoded

    def forget(self) -> None:
        """Forgets the points: the next ones may be of an earlier time."""
        with self._lock:
            self._next_s = 0
            self._encoded = self._encoded[0] + 1, framed(CLOUD, 0, b"")

    def _points(self, type: str, payload: bytes) -> Floats | None:
        lens = self._scene.lens(_DEPTH)
        try:
            message = decoder(type)(payload)
            pose = self._scene.pose_at(_DEPTH, header_stamp_ns(message.header))
            if lens is None or pose is None:
                return None
            step = math.ceil(math.sqrt(lens.height * lens.width / _MOST_POINTS))
            points = points_of(pixels_of(message), lens, step).reshape(-1, 3)
        except ValueError:
            return None
        known = points[np.isfinite(points).all(axis=1)]
        return np.asarray(known @ pose[:3, :3].T + pose[:3, 3], "<f4")

"""Makes the points of the newest depth image, for the 3D view and for snapshots."""

import math
import threading
import time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ml2_receiver.topics.stamps import header_stamp_ns

from ..bags.decoding import decoder
from ..geometry.lens import Floats, Lens
from ..geometry.pose import Pose
from ..images.pixels import pixels_of
from ..products.points import colours_of, points_of
from .newest_image import Newest, NewestImage, framed
from .scene import Scene

CLOUD = "cloud"
_DEPTH, _COLOR = "depth", "color"
_MOST_HZ = 5
_MOST_POINTS = 5000
# The colour of points that the RGB camera does not see.
_UNSEEN = 0x808080
# Messages for browsers have one of these in the place of the end of the colour scale.
_PLAIN, _COLOURED = 0.0, 1.0


class Points(NamedTuple):
    """Points in the world frame, n x 3, and the red, green and blue of each if they are known."""

    places: Floats
    colours: NDArray[np.uint8] | None


class Cloud:
    """The points of the newest depth image in the world frame, at most 5000. Thread-safe."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._lock = threading.Lock()
        self._used = 0
        self._next_s = 0.0
        self._encoded: tuple[int, bytes] = 0, b""

    def encoded(self, depth: NewestImage, color: NewestImage) -> tuple[int, bytes]:
        """Returns the number of the cloud, from 1, and its message for browsers; 0 before it.

        The message is that of an image, with x, y and z of each point as float32 instead of a JPEG.
        If the number before them is 1, red, green and blue of each point follow as bytes.
        """
        with self._lock:
            now_s = time.monotonic()
            newest = depth.newest
            number = newest[0]
            if number not in (0, self._used) and now_s >= self._next_s:
                self._used, self._next_s = number, now_s + 1 / _MOST_HZ
                points = points_in_world(self._scene, newest, color.newest, _MOST_POINTS)
                if points is not None:
                    self._encoded = self._encoded[0] + 1, _message(points)
            return self._encoded

    def forget(self) -> None:
        """Forgets the points: the next ones may be of an earlier time."""
        with self._lock:
            self._next_s = 0
            self._encoded = self._encoded[0] + 1, framed(CLOUD, _PLAIN, b"")


def points_in_world(scene: Scene, depth: Newest, color: Newest, most: float) -> Points | None:
    """Returns points of the newest depth image; None without its pose and lens.

    They have colours if the scene has pose and lens of the newest RGB image.

    Args:
        most: how many of its pixels are taken at most.
    """
    image = _placed(scene, _DEPTH, depth, channels=())
    if image is None:
        return None
    step = math.ceil(math.sqrt(max(1, image.lens.height * image.lens.width / most)))
    flat = points_of(image.pixels, image.lens, step).reshape(-1, 3)
    is_known = np.isfinite(flat).all(axis=1)
    pose = image.pose
    places = np.asarray(flat[is_known] @ pose[:3, :3].T + pose[:3, 3], "<f4")
    return Points(places, _colours(scene, color, places))


class _Placed(NamedTuple):
    """An image, its lens, and the pose of its camera in the world frame as a 4 x 4 matrix."""

    pixels: NDArray[Any]
    lens: Lens
    pose: Pose


def _placed(scene: Scene, key: str, newest: Newest, channels: tuple[int, ...]) -> _Placed | None:
    """Returns the newest image of the camera `key`.

    Returns None without its pose or its lens, or if its pixels are not height x width x `channels`.
    """
    _, type, payload = newest
    lens = scene.lens(key)
    if not type or lens is None:
        return None
    try:
        message = decoder(type)(payload)
        pose = scene.pose_at(key, header_stamp_ns(message.header))
        pixels = pixels_of(message)
    except ValueError:
        return None
    if pose is None or pixels.shape != (lens.height, lens.width, *channels):
        return None
    return _Placed(pixels, lens, pose)


def _colours(scene: Scene, color: Newest, places: Floats) -> NDArray[np.uint8] | None:
    image = _placed(scene, _COLOR, color, channels=(3,))
    if image is None:
        return None
    inverse = np.linalg.inv(image.pose)
    packed = colours_of(places[np.newaxis], inverse, image.lens, image.pixels).ravel()
    packed[packed == 0] = _UNSEEN
    return np.ascontiguousarray(packed.astype(">u4").view(np.uint8).reshape(-1, 4)[:, 1:])


def _message(points: Points) -> bytes:
    places, colours = points
    if colours is None:
        return framed(CLOUD, _PLAIN, places.tobytes())
    return framed(CLOUD, _COLOURED, places.tobytes() + colours.tobytes())

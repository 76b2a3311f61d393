"""Corners followed from image to image."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

type Pixels = NDArray[np.float32]
type Grey = NDArray[np.uint8]

_MOST = 500
_APART_PX = 16
_QUALITY = 0.005
_WINDOW_PX = 21
_LEVELS = 4
# A corner that does not lead back to where it came from is another one.
_MOST_ASTRAY_PX = 0.7
_BORDER_PX = 8
_STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 20, 0.02)


class Tracks:
    """The corners that are followed now, by Lucas and Kanade's method on pyramids.

    Attributes:
        ids: one number for each, never used again.
        pixels: n x 2, where they are in the last image.
    """

    def __init__(self) -> None:
        self.ids = np.zeros(0, np.int64)
        self.pixels: Pixels = np.zeros((0, 2), np.float32)
        self._next = 0
        self._last: Grey | None = None

    def follow(self, image: Grey, expected: Pixels) -> None:
        """Finds them again near `expected`, n x 2; those that are not found are no more."""
        if self._last is not None and len(self.ids):
            found, is_found = _flow(self._last, image, self.pixels, expected)
            back, is_back = _flow(image, self._last, found, self.pixels)
            astray_px = np.linalg.norm(back - self.pixels, axis=1)
            height, width = image.shape
            is_inside = (found >= _BORDER_PX) & (found < (width - _BORDER_PX, height - _BORDER_PX))
            is_good = is_found & is_back & (astray_px < _MOST_ASTRAY_PX) & is_inside.all(axis=1)
            self.pixels = found
            self.keep(is_good)
        self._last = image

    def keep(self, is_kept: NDArray[np.bool_]) -> None:
        """Gives up the others."""
        self.ids, self.pixels = self.ids[is_kept], self.pixels[is_kept]

    def replenish(self, mask: Grey) -> None:
        """Adds corners of the last image where there are none and `mask` is not 0."""
        assert self._last is not None
        free = mask.copy()
        for x, y in self.pixels.round().astype(int).tolist():
            cv2.circle(free, (x, y), _APART_PX, (0,), -1)
        wanted = _MOST - len(self.ids)
        if wanted <= 0:
            return
        found = cv2.goodFeaturesToTrack(self._last, wanted, _QUALITY, _APART_PX, mask=free)
        if found is None:
            return
        corners = found.reshape(-1, 2).astype(np.float32)
        new = np.arange(self._next, self._next + len(corners))
        self._next += len(corners)
        self.ids = np.concatenate([self.ids, new])
        self.pixels = np.concatenate([self.pixels, corners])


def _flow(
    before: Grey, after: Grey, points: Pixels, expected: Pixels
) -> tuple[Pixels, NDArray[np.bool_]]:
    window = (_WINDOW_PX, _WINDOW_PX)
    found, status, _ = cv2.calcOpticalFlowPyrLK(
        before,
        after,
        points,
        expected.copy(),
        winSize=window,
        maxLevel=_LEVELS,
        criteria=_STOP,
        flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
    )
    return found.astype(np.float32, copy=False), status.ravel() == 1

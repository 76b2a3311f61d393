"""Writes images as PNG files, several at a time."""

import os
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import cv2
from numpy.typing import NDArray

from ml2_receiver.private_files import write_private_file

from ..errors import ExportError

# Images under way: their payloads and pixels are in memory.
_MOST = 8


class PngFiles:
    """Decodes, encodes and writes in threads, since OpenCV does not hold the interpreter's lock.

    Leaving the context waits for all files.
    """

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(len(os.sched_getaffinity(0)))
        self._under_way: deque[Future[None]] = deque()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: TracebackType | object) -> None:
        try:
            while self._under_way and kind is None:
                self._under_way.popleft().result()
        finally:
            self._pool.shutdown(cancel_futures=True)

    def write(self, path: Path, topic: str, image: Callable[[], NDArray[Any]]) -> None:
        """Calls `image` in a thread, and writes what it returns.

        Raises:
            ExportError: `image` raised ValueError for one of the last images.
            OSError: one of them cannot be written.
        """
        if len(self._under_way) == _MOST:
            self._under_way.popleft().result()
        self._under_way.append(self._pool.submit(_write, path, topic, image))


def _write(path: Path, topic: str, image: Callable[[], NDArray[Any]]) -> None:
    try:
        pixels = image()
    except ValueError as error:
        raise ExportError(f"{topic}: {error}") from error
    # With any level, 1 too, OpenCV tries all filters of PNG, which takes twice the time.
    is_encoded, png = cv2.imencode(".png", pixels)
    assert is_encoded
    write_private_file(path, png.data)

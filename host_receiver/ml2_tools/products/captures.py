"""Collects the messages of one capture, which share a stamp."""

from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

from ..monitoring.losses import Losses

# Enough for the transforms and images of two thirds of a second.
_MOST_STAMPS = 64


class Captures:
    """The captures of one camera that are not complete yet.

    Args:
        parts: the names of a capture's parts; the first is its image.
        losses: counts, by missing part, the images that newer captures pushed out.
    """

    def __init__(self, camera: str, parts: tuple[str, ...], losses: Losses) -> None:
        self.parts = parts
        self._camera, self._losses = camera, losses
        self._pending: OrderedDict[int, dict[str, Any]] = OrderedDict()

    def add(self, part: str, stamp_ns: int, value: Any) -> Mapping[str, Any] | None:
        """Adds one part; returns the capture by part if it is complete now, else None."""
        capture = self._pending.setdefault(stamp_ns, {})
        capture[part] = value
        if len(capture) == len(self.parts):
            return self._pending.pop(stamp_ns)
        if len(self._pending) > _MOST_STAMPS:
            _, oldest = self._pending.popitem(last=False)
            if self.parts[0] in oldest:
                missing = [part for part in self.parts if part not in oldest]
                self._losses.add(f"{self._camera}: no {' or '.join(missing)} for an image")
        return None

"""Which streams nobody needs at present, if subscribers come and go quickly."""

from collections.abc import Callable, Collection

# Opening a camera takes up to a second, and each change interrupts the lanes. Whoever may subscribe
# in ROS or on Zenoh could cause it many times per second. A person who looks at one image after the
# other comes back within this time.
STAYS_S = 5.0


class Demand:
    """Lets a stream that a subscriber started run on for STAYS_S after the last one has gone.

    A stream that ran before anybody needed it ends at once. Not thread-safe.

    Args:
        idle: returns the streams that have no subscriber now.
    """

    def __init__(self, idle: Callable[[], Collection[str]]) -> None:
        self._idle = idle
        self._before: frozenset[str] = frozenset()
        self._started: set[str] = set()
        self._stays_until_s: dict[str, float] = {}

    def idle_streams(self, now_s: float) -> frozenset[str]:
        """Returns the streams that shall rest; `now_s` is monotonic time."""
        idle = frozenset(self._idle())
        self._started |= self._before - idle
        for stream in (idle - self._before) & self._started:
            self._stays_until_s[stream] = now_s + STAYS_S
        for stream, until_s in list(self._stays_until_s.items()):
            if stream not in idle:
                del self._stays_until_s[stream]
            elif now_s >= until_s:
                del self._stays_until_s[stream]
                self._started.remove(stream)
        self._before = idle
        return idle - self._stays_until_s.keys()

    def is_due(self, now_s: float) -> bool:
        """Returns True if a stream has run on for long enough."""
        return any(now_s >= until_s for until_s in self._stays_until_s.values())

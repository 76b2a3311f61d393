"""Finds streams that no output needs, though subscribers come and go quickly."""

from collections.abc import Mapping

# Opening a camera takes up to a second, and each change interrupts the lanes. Whoever may subscribe
# in ROS or on Zenoh could cause it many times per second. A person who looks at one image after the
# other comes back within this time.
STAYS_S = 5.0


class Demand:
    """Decides which streams are idle: some output publishes them, and no output needs them.

    A stream that a subscriber started runs on for STAYS_S after the last one has gone; one that ran
    before anybody needed it ends at once. Any thread may call push(); idle_streams() is for one at
    a time.
    """

    def __init__(self) -> None:
        self._outputs: dict[str, Mapping[str, bool]] = {}
        self._before: frozenset[str] = frozenset()
        self._started: set[str] = set()
        self._stays_until_s: dict[str, float] = {}

    def push(self, output: str, streams: Mapping[str, bool]) -> None:
        """Takes the streams that an output publishes now, each with whether it is needed."""
        self._outputs[output] = dict(streams)

    def idle_streams(self, now_s: float) -> frozenset[str]:
        """Returns the streams that shall rest; `now_s` is monotonic time."""
        outputs = list(self._outputs.values())
        published = frozenset[str]().union(*outputs)
        idle = published - {it for streams in outputs for it in streams if streams[it]}
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

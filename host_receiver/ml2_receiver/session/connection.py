"""A connection without I/O, and the routes of its DATA frames."""

from dataclasses import dataclass, field

from ..errors import ErrorCode, ProtocolError, PublishError
from ..wire.frame import CDR_ENCAPSULATION, Frame
from ..wire.kinds import Lane
from .openings import Openings
from .sink import Publish
from .statistics import TopicStatistics
from .will import Will


class Route:
    """The publish function and the counters of one channel.

    Only the reader thread of the channel's lane uses them, but `publish` may change at any time.
    """

    __slots__ = ("publish", "statistics", "will")

    def __init__(
        self, publish: Publish, statistics: TopicStatistics, will: Will | None = None
    ) -> None:
        self.publish = publish
        self.statistics = statistics
        self.will = will

    def receive(self, frame: Frame, received_ns: int, now_ns: int) -> None:
        """Counts and publishes a DATA frame that arrived at `received_ns`; both are ROS time.

        Raises:
            ProtocolError: `malformed`.
        """
        header, payload = frame
        if not payload.startswith(CDR_ENCAPSULATION):
            raise ProtocolError(
                ErrorCode.MALFORMED,
                f"DATA of channel {header.channel} begins with {bytes(payload[:4]).hex(' ')!r}, "
                f"expected {CDR_ENCAPSULATION.hex(' ')!r}",
            )
        if not self.statistics.record(header, received_ns, now_ns):
            raise ProtocolError(
                ErrorCode.MALFORMED,
                f"DATA of channel {header.channel} has number {header.sequence} after "
                f"{self.statistics.last_number}",
            )
        try:
            if self.will is None:
                self.publish(payload)
            else:
                self.will.publish(self.publish, payload)
        except PublishError:
            self.statistics.unpublished += 1


@dataclass(eq=False)
class Connection:
    """One connection of a peer.

    `opened_s` is monotonic time. `peer` is the fingerprint of the peer's certificate, None before
    the handshake and without TLS. `lane` is None until the connection belongs to a session.
    `routes` maps the channels of the lane to their routes; it is empty before START. `openings` is
    None in a session without them.
    """

    host: str
    port: int
    opened_s: float
    peer: str | None = None
    lane: Lane | None = None
    routes: dict[int, Route] = field(default_factory=dict)
    openings: Openings | None = None
    is_closing: bool = False

    def end_wills(self) -> None:
        """Takes the end of the lane: no DATA follows."""
        for route in list(self.routes.values()):
            if route.will is not None:
                route.will.close()

    @property
    def name(self) -> str:
        """The name of its lane, for messages."""
        return self.lane.name if self.lane else "new connection"

    @property
    def address(self) -> str:
        """The peer's HOST:PORT."""
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

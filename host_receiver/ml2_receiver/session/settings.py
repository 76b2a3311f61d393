"""The settings that do not change while a receiver runs."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ..configuration.app_rules import AppRules
from ..table.reader import load_table
from ..table.stream_table import StreamTable
from ..wire.frame import VERSION
from ..wire.kinds import LINK_TEST, ROS_LANES, Kind
from ..wire.messages import Hello, PeerLimits, Timeouts, Welcome
from .books import Books
from .downlink import Downlink
from .graph import Graph
from .openings import Openings


@dataclass(frozen=True)
class Limits:
    """The receiver's limits, from PROTOCOL.md; tests make some tighter, others looser."""

    handshake_s: float = 5.0
    ping_s: float = 0.5
    dead_s: float = 3.0
    linger_s: float = 1.0
    unfinished_connections: int = 16
    connections_per_address: int = 64
    failed_attempts: int = 10
    failed_attempts_per_s: float = 1.0
    shared_address_s: float = 24 * 3600.0
    shared_failed_attempts: int = 100
    shared_failed_attempts_per_s: float = 50.0


@dataclass(frozen=True)
class ReceiverSettings:
    """The settings of a receiver.

    Attributes:
        name: the receiver's name, as headsets see it.
        software: its program and version, as headsets see it.
        frame_prefix: the prefix of the headsets' frame ids.
        excluded: streams that no headset is ever asked for, with the reasons.
        limits: time-outs, and the number of connections and failed attempts.
        app: returns what the user lets apps do now.
        graph: carries out the openings of apps; None offers none.
        table: all possible streams.
    """

    name: str
    software: str
    frame_prefix: str = ""
    excluded: Mapping[str, str] = field(default_factory=dict)
    limits: Limits = field(default_factory=Limits)
    app: Callable[[], AppRules] = AppRules
    graph: Graph | None = None
    table: StreamTable = field(default_factory=load_table)

    def openings(self, hello: Hello, books: Books) -> Openings | None:
        """Returns the openings of a new session; None if one of the sides has none."""
        if self.graph is None or not hello.capabilities.ros:
            return None
        return Openings(self.app, self.graph, Downlink(books))

    def lanes(self, openings: Openings | None) -> tuple[str, ...]:
        """Returns the names of the lanes that can be joined in a session."""
        of_openings = ROS_LANES if openings else ()
        others = (lane.name for lane in (LINK_TEST, *of_openings))
        return (*self.table.needed_lanes, *self.table.lanes, *others)

    def welcome(
        self,
        session: str,
        tickets: Mapping[str, str],
        received: Mapping[str, int] | None,
        openings: Openings | None = None,
    ) -> Welcome:
        """Returns the WELCOME of a session; `received` is None for a new instance of the app."""
        limits = self.limits
        return Welcome(
            version=VERSION,
            session=session,
            name=self.name,
            software=self.software,
            tickets=tickets,
            received=received,
            limits=PeerLimits(Kind.DATA.max_length),
            timeouts=Timeouts(limits.handshake_s, limits.ping_s, limits.dead_s),
            ros=openings.allowed if openings else None,
        )

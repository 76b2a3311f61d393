"""The settings that do not change while a receiver runs."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from ..table.reader import load_table
from ..table.stream_table import StreamTable
from ..wire.frame import VERSION
from ..wire.kinds import Kind
from ..wire.messages import PeerLimits, Timeouts, Welcome


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
        table: all possible streams.
    """

    name: str
    software: str
    frame_prefix: str = ""
    excluded: Mapping[str, str] = field(default_factory=dict)
    limits: Limits = field(default_factory=Limits)
    table: StreamTable = field(default_factory=load_table)

    def welcome(
        self, session: str, tickets: Mapping[str, str], received: Mapping[str, int] | None
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
        )

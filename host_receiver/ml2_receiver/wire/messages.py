"""The JSON bodies of frames; PROTOCOL.md says what their keys mean."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from .frame import CDR_ENCAPSULATION
from .json_body import JsonBody, Scalar, check_text
from .opening_bodies import CallStatus, SubscriptionStatus

NAME_CHARACTERS = 64
ID_CHARACTERS = 128
_REASON_CHARACTERS = 200
_BEST_QUALITY = 100
_WILL_BYTES = 2048
MAX_LINK_TEST_BYTES = 64 << 20

ClockState = Literal["waiting", "synchronised", "holdover", "frozen"]
TimestampBase = Literal["boottime", "monotonic"]
StreamState = Literal["running", "waiting", "refused", "available", "failed"]
Thermal = Literal["none", "light", "moderate", "severe", "critical", "emergency", "shutdown"]


@dataclass(frozen=True)
class Capabilities:
    streams: list[str]
    ros: bool | None = None


@dataclass(frozen=True)
class ChannelStatus:
    produced: int
    sent: int
    dropped: Mapping[str, int]

    def __post_init__(self) -> None:
        if min(self.produced, self.sent, *self.dropped.values()) < 0:
            raise ValueError("counts are not negative")


@dataclass(frozen=True)
class Hello(JsonBody):
    versions: list[int]
    device_id: str
    instance_id: str
    name: str
    software: str
    capabilities: Capabilities
    permissions: Mapping[str, bool]
    channels: Mapping[str, ChannelStatus] | None = None

    def __post_init__(self) -> None:
        check_text("name", self.name, NAME_CHARACTERS)
        for key in ("device_id", "instance_id", "software"):
            check_text(key, getattr(self, key), ID_CHARACTERS)


@dataclass(frozen=True)
class PeerLimits:
    data_bytes: int


@dataclass(frozen=True)
class Timeouts:
    handshake_s: float
    ping_s: float
    dead_s: float

    def __post_init__(self) -> None:
        if min(self.handshake_s, self.ping_s, self.dead_s) <= 0:
            raise ValueError("timeouts are above 0")


@dataclass(frozen=True)
class AllowedUses:
    subscribe: bool
    publish: bool
    call: bool
    offer: bool


@dataclass(frozen=True)
class Welcome(JsonBody):
    version: int
    session: str
    name: str
    software: str
    tickets: Mapping[str, str]
    received: Mapping[str, int] | None
    limits: PeerLimits
    timeouts: Timeouts
    ros: AllowedUses | None = None

    def __post_init__(self) -> None:
        check_text("name", self.name, NAME_CHARACTERS)
        check_text("software", self.software, ID_CHARACTERS)


@dataclass(frozen=True)
class Join(JsonBody):
    session: str
    ticket: str
    lane: str


@dataclass(frozen=True)
class Joined(JsonBody):
    lane: str


@dataclass(frozen=True)
class Link:
    adapts: bool
    most_mbit_per_s: float | None = None

    def __post_init__(self) -> None:
        if self.most_mbit_per_s is not None and self.most_mbit_per_s <= 0:
            found = self.most_mbit_per_s
            raise ValueError(f"most_mbit_per_s: expected a number above 0, found {found}")


@dataclass(frozen=True)
class Configure(JsonBody):
    request: int
    streams: Mapping[str, Mapping[str, Scalar]]
    frame_prefix: str | None = None
    link: Link | None = None


@dataclass(frozen=True)
class StreamAnswer:
    result: Literal["applied", "adjusted", "refused"]
    values: Mapping[str, Scalar] | None = None
    reason: str | None = None

    def __post_init__(self) -> None:
        if self.values is None and self.result != "refused":
            raise ValueError(f"values: missing although {self.result}")
        if self.reason is None and self.result != "applied":
            raise ValueError(f"reason: missing although {self.result}")


@dataclass(frozen=True)
class Configured(JsonBody):
    request: int
    streams: Mapping[str, StreamAnswer]


@dataclass(frozen=True)
class WillBody:
    payload: str
    silent_ms: int

    def __post_init__(self) -> None:
        if not 50 <= self.silent_ms <= 5000:
            raise ValueError(f"silent_ms: expected 50 to 5000, found {self.silent_ms}")
        if len(self.message) > _WILL_BYTES or not self.message.startswith(CDR_ENCAPSULATION):
            raise ValueError(f"payload: expected a Payload of at most {_WILL_BYTES} bytes")

    @cached_property
    def message(self) -> bytes:
        """The Payload. Raises ValueError if it is not Base64."""
        try:
            return base64.b64decode(self.payload, validate=True)
        except ValueError as error:
            raise ValueError(f"payload: expected Base64: {error}") from error


@dataclass(frozen=True)
class Channel(JsonBody):
    id: int
    stream: str
    role: str
    topic: str
    type: str
    qos: str
    frame_id: str
    lane: str
    will: WillBody | None = None

    def __post_init__(self) -> None:
        if not 1 <= self.id <= 0xFFFF:
            raise ValueError(f"id: expected 1 to 65535, found {self.id}")


@dataclass(frozen=True)
class ChannelEnd(JsonBody):
    id: int


@dataclass(frozen=True)
class Start(JsonBody):
    request: int
    channels: int | None = None


@dataclass(frozen=True)
class LinkTest(JsonBody):
    bytes: int

    def __post_init__(self) -> None:
        if not 1 <= self.bytes <= MAX_LINK_TEST_BYTES:
            raise ValueError(f"bytes: expected 1 to {MAX_LINK_TEST_BYTES}, found {self.bytes}")


@dataclass(frozen=True)
class ClockStatus:
    state: ClockState
    offset_ns: int
    uncertainty_ns: int
    round_trip_ns: int
    skew_ppm: float | None = None
    steps: int | None = None
    epoch: int | None = None
    bases: Mapping[str, TimestampBase] | None = None

    def __post_init__(self) -> None:
        if min(self.steps or 0, self.epoch or 0) < 0:
            raise ValueError("counts are not negative")


@dataclass(frozen=True)
class StreamStatus:
    state: StreamState
    reason: str | None = None
    permission: str | None = None
    quality: int | None = None
    rate_hz: int | None = None

    def __post_init__(self) -> None:
        if self.reason is not None and len(self.reason) > _REASON_CHARACTERS:
            raise ValueError(f"reason: expected at most {_REASON_CHARACTERS} characters")
        if self.permission is not None:
            check_text("permission", self.permission, ID_CHARACTERS)
        if self.quality is not None and not 1 <= self.quality <= _BEST_QUALITY:
            raise ValueError(f"quality: expected 1 to {_BEST_QUALITY}, found {self.quality}")
        if self.rate_hz is not None and self.rate_hz < 1:
            raise ValueError(f"rate_hz: expected at least 1, found {self.rate_hz}")


@dataclass(frozen=True)
class Condition:
    """The judgement of the headset on how well it perceives something."""

    level: Literal["ok", "warn"]
    message: str
    values: Mapping[str, str]

    def __post_init__(self) -> None:
        if len(self.message) > _REASON_CHARACTERS:
            raise ValueError(f"message: expected at most {_REASON_CHARACTERS} characters")
        if "type" in self.values:  # which marks the rows of topics
            raise ValueError("values: type is not a name")


@dataclass(frozen=True)
class Status(JsonBody):
    final: bool
    uptime_s: float
    channels: Mapping[str, ChannelStatus]
    clock: ClockStatus
    thermal: Thermal | None = None
    streams: Mapping[str, StreamStatus] | None = None
    openings: Mapping[str, SubscriptionStatus] | None = None
    calls: Mapping[str, CallStatus] | None = None
    conditions: Mapping[str, Condition] | None = None


@dataclass(frozen=True)
class Event(JsonBody):
    event: str
    text: str
    age_s: float | None = None

    def __post_init__(self) -> None:
        if (self.age_s or 0) < 0:
            raise ValueError("ages are not negative")

    @property
    def text_and_age(self) -> str:
        """The text, quoted, and its age if it was delayed by 1 s or more."""
        if self.age_s is None or self.age_s < 1:
            return repr(self.text)
        return f"{self.text!r}, {self.age_s:.0f} s ago"


@dataclass(frozen=True)
class Error(JsonBody):
    code: str
    message: str
    fatal: bool
    channel: int | None = None


@dataclass(frozen=True)
class Bye(JsonBody):
    reason: str

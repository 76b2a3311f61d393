"""The JSON bodies of openings, and the bodies of POSE; PROTOCOL.md says what their keys mean."""

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from ..errors import ErrorCode, ProtocolError
from .frame import CDR_ENCAPSULATION, Frame
from .json_body import JsonBody, check_text
from .kinds import ROS_LANES, Body, Kind

OPENING_KINDS = ("subscription", "client", "service", "transform")
_LANES = [it.name for it in ROS_LANES]
_NAME_CHARACTERS = 255
DEFAULT_DEPTH, _DEEPEST_QUEUE = 10, 100
_POSE = struct.Struct("<7dq")


@dataclass(frozen=True)
class Open(JsonBody):
    id: int
    kind: str
    name: str | None = None
    type: str | None = None
    hash: str | None = None
    layout: str | None = None
    keep: Literal["latest", "all"] | None = None
    depth: int | None = None
    max_hz: float | None = None
    bulk: bool | None = None
    received: int | None = None
    frame: str | None = None
    reference: str | None = None

    def __post_init__(self) -> None:
        _check_id(self.id)
        needed = ("frame", "reference") if self.kind == "transform" else ("name", "type")
        for key in needed if self.kind in OPENING_KINDS else ():
            if getattr(self, key) is None:
                raise ValueError(f"{key}: missing although {self.kind}")
        for key in ("kind", "name", "type", "frame", "reference"):
            if (text := getattr(self, key)) is not None:
                check_text(key, text, _NAME_CHARACTERS)
        if self.depth is not None and not 1 <= self.depth <= _DEEPEST_QUEUE:
            raise ValueError(f"depth: expected 1 to {_DEEPEST_QUEUE}, found {self.depth}")
        if self.max_hz is not None and self.max_hz <= 0:
            raise ValueError(f"max_hz: expected a number above 0, found {self.max_hz}")
        if self.received is not None and not 0 <= self.received < 1 << 32:
            raise ValueError(f"received: expected 0 to 4294967295, found {self.received}")


@dataclass(frozen=True)
class Opened(JsonBody):
    id: int
    result: Literal["opened", "refused"]
    name: str | None = None
    lane: str | None = None
    latched: bool | None = None
    reason: str | None = None
    code: str | None = None
    checked: Literal["hash", "layout", "no"] | None = None

    def __post_init__(self) -> None:
        _check_id(self.id)
        needed = "lane" if self.result == "opened" else "reason"
        if getattr(self, needed) is None:
            raise ValueError(f"{needed}: missing although {self.result}")
        if self.lane is not None and self.lane not in _LANES:
            raise ValueError(f"lane: expected one of {_LANES}, found {self.lane!r}")
        if self.name is not None:
            check_text("name", self.name, _NAME_CHARACTERS)


@dataclass(frozen=True)
class Close(JsonBody):
    id: int

    def __post_init__(self) -> None:
        _check_id(self.id)


@dataclass(frozen=True)
class Closed(JsonBody):
    id: int
    reason: str
    code: str | None = None

    def __post_init__(self) -> None:
        _check_id(self.id)


@dataclass(frozen=True)
class SubscriptionStatus:
    """The device's counters of a subscription, since its app asked for it."""

    received: int
    taken: int
    superseded: int
    queue_full: int
    undecodable: int

    def __post_init__(self) -> None:
        if min(vars(self).values()) < 0:
            raise ValueError("counts are not negative")


@dataclass(frozen=True)
class CallStatus:
    """The device's counters of a client or a service, since its app made it; failures by code."""

    requests: int
    responses: int
    failures: Mapping[str, int]

    def __post_init__(self) -> None:
        if min(self.requests, self.responses, *self.failures.values()) < 0:
            raise ValueError("counts are not negative")


@dataclass(frozen=True)
class Failure(JsonBody):
    code: str
    message: str


class Pose(NamedTuple):
    """A position in m, a unit quaternion, and the stamp in ns that shows how stale they are."""

    x: float
    y: float
    z: float
    qx: float
    qy: float
    qz: float
    qw: float
    newest_ns: int

    @classmethod
    def parse(cls, body: bytes | bytearray) -> "Pose":
        """Returns the pose in a body of 64 bytes.

        Raises:
            ProtocolError: `malformed`: a number is not finite.
        """
        pose = cls._make(_POSE.unpack(body))
        if not all(map(math.isfinite, pose)):
            raise ProtocolError(ErrorCode.MALFORMED, f"expected finite numbers, found {pose}")
        return pose

    def to_bytes(self) -> bytes:
        return _POSE.pack(*self)


def check_body(kind: Kind, frame: Frame) -> None:
    """Checks the body of a frame of the app in an opening.

    Raises:
        ProtocolError: `malformed`: it is no Payload, or no Failure.
    """
    if kind.body is Body.JSON:
        Failure.parse(frame.body)
    elif kind.body is Body.PAYLOAD and not frame.body.startswith(CDR_ENCAPSULATION):
        found, expected = bytes(frame.body[:4]).hex(" "), CDR_ENCAPSULATION.hex(" ")
        reason = f"{kind.name} begins with {found!r}, expected {expected}"
        raise ProtocolError(ErrorCode.MALFORMED, reason)


def _check_id(id: int) -> None:
    if not 1 <= id <= 0xFFFF:
        raise ValueError(f"id: expected 1 to 65535, found {id}")

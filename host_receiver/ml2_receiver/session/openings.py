"""The openings of one session as a state machine without I/O; PROTOCOL.md, Openings."""

import threading
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Self

from ..configuration.app_rules import AppRules
from ..errors import ErrorCode, ProtocolError
from ..table.stream_table import Topic
from ..wire.frame import Frame
from ..wire.kinds import KIND_BY_NUMBER, ROS, Kind
from ..wire.messages import AllowedUses, Status
from ..wire.opening_bodies import OPENING_KINDS, Close, Closed, Failure, Open, Opened, check_body
from .downlink import Downlink
from .graph import Graph, in_words, refused
from .report import CallsReport, OpeningsReport

_MOST_OPENINGS = 64
_MOST_REQUESTS = 16  # of an opening
_MOST_REQUESTS_TOGETHER = 64
_NUMBERS = 1 << 32
# The kinds of frames that an app may send on the lanes of openings.
LANE_KINDS = frozenset({Kind.TAKEN, Kind.REQUEST, Kind.RESPONSE, Kind.FAILURE})
# The kinds of frames that an app may send, by the kind of its opening.
_KINDS: dict[str, tuple[Kind, ...]] = {
    "subscription": (Kind.TAKEN,),
    "client": (Kind.REQUEST,),
    "service": (Kind.RESPONSE, Kind.FAILURE),
    "transform": (),
}


@dataclass
class _Opening:
    """`name` and `lane` are those of one that is open. Numbers are the last of their kind."""

    kind: str
    type: str
    name: str = ""
    lane: str | None = None
    sent: int | None = None
    taken: int | None = None
    asked: int | None = None
    requested: int | None = None
    unanswered: set[int] = field(default_factory=set)
    under_way: set[int] = field(default_factory=set)
    counts: Counter[Kind] = field(default_factory=Counter)


class Openings:
    """The openings of the app; refuses frames that are not legal for them. Thread-safe.

    Args:
        rules: returns what the user lets apps do now.
        graph: carries out what they open.
        downlink: takes its messages.

    Attributes:
        late: frames of openings that have ended, and answers that nobody waits for.
    """

    def __init__(self, rules: Callable[[], AppRules], graph: Graph, downlink: Downlink) -> None:
        self.late = 0
        self.downlink = downlink
        downlink.sending = self.sent
        downlink.begins = self.begins
        self._rules, self._graph = rules, graph
        self._held_to = rules()
        self._lock = threading.Lock()
        self._is_joined = False
        self._used: set[int] = set()
        self._live: dict[int, _Opening] = {}
        self._last: dict[int, _Opening] = {}  # those that were open when the session ended

    @property
    def allowed(self) -> AllowedUses:
        """The uses for which any rule is there."""
        rules = self._rules()
        uses = (rules.subscribe, rules.publish, rules.call, rules.offer)
        return AllowedUses(*(bool(use.rules) for use in uses))

    @property
    def rules(self) -> AppRules:
        """The rules of the user, as they are now."""
        return self._rules()

    def forbidden(self, topic: Topic) -> str | None:
        """Returns why the app may not publish a topic of an absolute name; None if it may."""
        try:
            name = self._graph.resolve(Open(1, "publisher", topic.name, topic.type))
        except ValueError as error:
            return in_words(str(error))
        return self._rules().forbidden("publisher", name)

    def joined(self, lane: str) -> Self:
        """Takes note of a lane, since nothing is opened before `ros`; returns the openings."""
        self._is_joined |= lane == ROS.name
        return self

    def answers(self, frame: Frame) -> list[tuple[Kind, Opened | Closed]] | None:
        """Returns what answers OPEN or CLOSE; None for any other frame.

        Raises:
            ProtocolError: `malformed` or `unexpected`.
        """
        if frame.header.kind == Kind.OPEN:
            return [(Kind.OPENED, self._open(Open.parse(frame.body)))]
        if frame.header.kind == Kind.CLOSE:
            closed = self.end(Close.parse(frame.body).id, "the app closed it")
            return [] if closed is None else [(Kind.CLOSED, closed)]
        return None

    def _open(self, wanted: Open) -> Opened:
        with self._lock:
            if not self._is_joined:
                raise _unexpected("OPEN before the lane ros is joined")
            if wanted.id in self._used:
                raise _unexpected(f"OPEN of {wanted.id}, which was opened before")
            self._used.add(wanted.id)
            is_full = len(self._live) >= _MOST_OPENINGS
            if not is_full:
                self._live[wanted.id] = opening = _Opening(wanted.kind, wanted.type or "")
        if is_full:
            reason = f"{_MOST_OPENINGS} names are open, which are the most"
            return refused(wanted, reason, "busy")
        answer, name = self._answer(wanted)
        with self._lock:
            if answer.result == "opened":
                opening.name, opening.lane = name, answer.lane
            else:
                del self._live[wanted.id]
        return answer

    def _answer(self, wanted: Open) -> tuple[Opened, str]:
        """Returns the answer, and the resolved name."""
        if wanted.kind not in OPENING_KINDS:
            return refused(wanted, f"this receiver cannot open a {wanted.kind!r}"), ""
        name = "/tf"
        if wanted.kind != "transform":
            try:
                name = self._graph.resolve(wanted)
            except ValueError as error:
                return refused(wanted, str(error), "name"), ""
        if (reason := self._rules().forbidden(wanted.kind, name)) is not None:
            return refused(wanted, reason, "rules"), name
        return self._graph.open(wanted, name, self.downlink), name

    def end(self, id: int, reason: str, code: str | None = None) -> Closed | None:
        """Ends an opening, and returns the CLOSED to send; None if it has ended already."""
        with self._lock:
            if self._find(id, "CLOSE") is None:
                return None
            del self._live[id]
        self._close(id, "closed")
        return Closed(id, in_words(reason), code)

    def _close(self, id: int, reason: str) -> None:
        self._graph.close(id)
        self.downlink.close(id, reason)

    def ended(self) -> list[Closed]:
        """Ends what the graph has ended or the rules have no more; returns what to tell the app."""
        endings = {**dict(self._forbidden_now()), **dict(self.downlink.endings())}
        found = (self.end(id, *ending) for id, ending in endings.items())
        return [it for it in found if it is not None]

    def _forbidden_now(self) -> Iterator[tuple[int, tuple[str, str]]]:
        if (rules := self._rules()) == self._held_to:
            return
        self._held_to = rules
        with self._lock:
            open = [(id, it) for id, it in self._live.items() if it.lane is not None]
        for id, opening in open:
            if (reason := rules.forbidden(opening.kind, opening.name)) is not None:
                yield id, (reason, "rules")

    def report(self, status: Status | None) -> OpeningsReport:
        """Returns what is open, with what the last STATUS says of it."""
        counted = (status and status.openings) or {}
        called = (status and status.calls) or {}
        with self._lock:
            open = {**self._live, **self._last}
            calls = [
                CallsReport(id, it.kind, it.name, it.type, it.counts.copy(), called.get(f"{id}"))
                for id, it in open.items()
                if it.kind in ("client", "service") and it.lane is not None
            ]
        return OpeningsReport(self.late, self.downlink.reports(counted), calls)

    def finish(self) -> None:
        """Ends all openings with their session."""
        with self._lock:
            self._last, self._live = self._live, {}
        for id in self._last:
            self._close(id, "link_down")

    def sent(self, id: int, number: int) -> None:
        """Takes note of a MESSAGE that is about to be sent."""
        with self._lock:
            if (opening := self._live.get(id)) is not None:
                opening.sent = number

    def begins(self, kind: Kind, id: int, number: int) -> bool:
        """Takes note that a REQUEST is asked, or one of the app answered; False if it has ended."""
        with self._lock:
            if (opening := self._live.get(id)) is None:
                return False
            opening.counts[kind] += 1
            if kind is Kind.REQUEST:
                opening.asked = number
                opening.unanswered.add(number)
            else:
                opening.under_way.discard(number)
            return True

    def received(self, lane: str, frame: Frame) -> Failure | None:
        """Takes a frame of an opening, and returns the FAILURE that answers it if it is too much.

        Raises:
            ProtocolError: `unexpected` or `malformed`.
        """
        header = frame.header
        kind, id, number = KIND_BY_NUMBER[header.kind], header.channel, header.sequence
        with self._lock:
            opening = self._find(id, kind.name)
            if opening is None and kind is Kind.TAKEN:
                self.downlink.taken(id, number)
            if opening is None:
                return None
            if opening.lane != lane or kind not in _KINDS[opening.kind]:
                where = f"{kind.name} on lane {lane} of opening {id}"
                raise _unexpected(f"{where}, a {opening.kind} on lane {opening.lane}")
            check_body(kind, frame)
            match kind:
                case Kind.TAKEN:
                    _take(opening, number)
                    self.downlink.taken(id, number)
                case Kind.REQUEST:
                    if self._is_too_much(opening, frame):
                        return Failure("busy", "too many requests are under way")
                case _:
                    if not self._is_awaited(opening, number):
                        return None
                    opening.counts[kind] += 1
        self._graph.received(frame)
        return None

    def _find(self, id: int, what: str) -> _Opening | None:
        opening = self._live.get(id)
        if opening is None:
            if id not in self._used:
                raise _unexpected(f"{what} of {id}, which was never opened")
            self.late += 1
        return opening

    def _is_too_much(self, opening: _Opening, request: Frame) -> bool:
        number, limit_ns = request.header.sequence, request.header.capture_ns
        if opening.requested is not None and not _is_after(number, opening.requested):
            raise _malformed(f"REQUEST has number {number} after {opening.requested}")
        if limit_ns <= 0:
            raise _malformed(f"REQUEST is waited for for {limit_ns} ns, expected more than 0")
        opening.requested = number
        opening.counts[Kind.REQUEST] += 1
        together = sum(len(it.under_way) for it in self._live.values())
        if len(opening.under_way) >= _MOST_REQUESTS or together >= _MOST_REQUESTS_TOGETHER:
            opening.counts[Kind.FAILURE] += 1
            return True
        opening.under_way.add(number)
        return False

    def _is_awaited(self, opening: _Opening, number: int) -> bool:
        if opening.asked is None or _is_after(number, opening.asked):
            raise _unexpected(f"an answer to request {number}, which was never asked")
        if number not in opening.unanswered:
            self.late += 1
            return False
        opening.unanswered.remove(number)
        return True


def _take(opening: _Opening, number: int) -> None:
    is_sent = opening.sent is not None and not _is_after(number, opening.sent)
    if not is_sent or (opening.taken is not None and not _is_after(number, opening.taken)):
        last = f"{opening.sent} was sent, {opening.taken} TAKEN last"
        raise _unexpected(f"TAKEN has number {number}; {last}")
    opening.taken = number


def _is_after(number: int, last: int) -> bool:
    return 0 < (number - last) % _NUMBERS < _NUMBERS // 2


def _unexpected(message: str) -> ProtocolError:
    return ProtocolError(ErrorCode.UNEXPECTED, message)


def _malformed(message: str) -> ProtocolError:
    return ProtocolError(ErrorCode.MALFORMED, message)

"""One session of a recording with a receiver."""

import struct
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress

from ml2_receiver.errors import PlaybackError, ProtocolError
from ml2_receiver.generated.version import VERSION
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.frame import VERSION as PROTOCOL_VERSION
from ml2_receiver.wire.frame import Kind
from ml2_receiver.wire.messages import (
    Bye,
    Capabilities,
    Channel,
    ChannelEnd,
    ChannelStatus,
    ClockStatus,
    Configure,
    Configured,
    Error,
    Hello,
    Join,
    Joined,
    Start,
    Status,
    Welcome,
)

from .answers import LEFT_OUT, Repertoire
from .lane import Destination, Lane

_STATUS_PERIOD_S = 1.0
_ROUND_TRIPS = 15  # one per STATUS: those of the last 15 s
_FAREWELL_S = 1.0
_TIME = struct.Struct("<q")


class Session:
    """From HELLO to BYE; finish() must be called.

    A thread answers what the receiver asks, another tells it each second how things stand.
    There is no clock to estimate, the stamps are those of the recording: the time lane carries
    one exchange per second, for the round trip.

    Args:
        name: of the headset that was recorded.
        say: is told, in a thread of this session, of what is refused and of what is not asked for.
        over: set when the receiver has ended the session; `reason` says why.

    Attributes:
        started: set by START.
        refused: why, by stream or topic, that the recording does not have or the receiver does
            not take.
        epoch: of the stamps; to be counted up when they begin again.

    Raises:
        PlaybackError: no receiver, or it does not want a session.
    """

    def __init__(
        self,
        destination: Destination,
        name: str,
        repertoire: Repertoire,
        say: Callable[[str], None],
        over: threading.Event,
    ) -> None:
        self.started = threading.Event()
        self.refused: dict[str, str] = {}
        self.epoch = 0
        self.reason: str | None = None
        self._destination, self._over = destination, over
        self._name, self._repertoire, self._say = name, repertoire, say
        self._began_s = time.monotonic()
        self._finishing = threading.Event()
        self._lanes: dict[str, Lane] = {}
        self._ids: dict[Topic, int] = {}
        self._sent: dict[Topic, int] = {}
        self._announced: frozenset[Topic] = frozenset()
        self._live: frozenset[Topic] = frozenset()
        self._request = 0
        self._round_trips_ns: deque[int] = deque(maxlen=_ROUND_TRIPS)
        self._control = self._lanes["control"] = Lane(destination, "control")
        try:
            self._welcome = self._greet()
            for lane in ("time", "sensors"):
                self._join(lane)
        except BaseException:
            self._close()
            raise
        self._threads = [
            threading.Thread(target=self._guard, args=[work], name=work.__name__)
            for work in (self._listen, self._tell)
        ]
        for thread in self._threads:
            thread.start()

    def is_wanted(self, topic: Topic) -> bool:
        """Whether the receiver has asked for it and is ready."""
        return topic in self._live

    def send(self, topic: Topic, payload: bytes, capture_ns: int) -> None:
        """One message, unchanged; waits for the receiver to take it."""
        sequence = self._sent.get(topic, 0)
        self._lanes[topic.lane].send(
            Kind.DATA,
            payload,
            channel=self._ids[topic],
            sequence=sequence,
            capture_ns=capture_ns,
            send_ns=time.time_ns(),
        )
        self._sent[topic] = sequence + 1

    def finish(self) -> None:
        """The final STATUS and BYE, if there is still someone to hear them."""
        self._finishing.set()
        self._threads[1].join()
        with suppress(PlaybackError, OSError):
            for lane in self._lanes.values():
                if lane is not self._control:
                    lane.end_output()
            self._status(is_final=True)
            self._control.set_timeout(_FAREWELL_S)
            self._control.send(Kind.BYE, Bye("the recording has ended"))
            self._control.end_output()
        self._threads[0].join()
        self._close()

    def _greet(self) -> Welcome:
        self._control.send(
            Kind.HELLO,
            Hello(
                versions=[PROTOCOL_VERSION],
                device_id=f"recording of {self._name}",
                instance_id=uuid.uuid4().hex,
                name=self._name,
                software=f"ml2-receiver play {VERSION}",
                capabilities=Capabilities(self._repertoire.streams),
                permissions={},
            ),
        )
        welcome = Welcome.parse(self._control.expect(Kind.WELCOME))
        self._control.set_timeout(welcome.timeouts.dead_s)
        return welcome

    def _join(self, name: str) -> None:
        lane = self._lanes[name] = Lane(self._destination, name)
        ticket = self._welcome.tickets.get(name, "")
        lane.send(Kind.JOIN, Join(self._welcome.session, ticket, name))
        Joined.parse(lane.expect(Kind.JOINED))
        lane.set_timeout(self._welcome.timeouts.dead_s)

    def _guard(self, work: Callable[[], None]) -> None:
        try:
            work()
        except (PlaybackError, ProtocolError) as error:
            self._end(str(error))

    def _end(self, reason: str) -> None:
        if not self._finishing.is_set() and self.reason is None:
            self.reason = reason
        self._finishing.set()
        self._over.set()

    def _listen(self) -> None:
        while (frame := self._control.receive()) is not None:
            match frame.header.kind:
                case Kind.CONFIGURE:
                    self._configure(Configure.parse(frame.payload))
                case Kind.START:
                    if Start.parse(frame.payload).request == self._request:
                        self._live = frozenset(
                            it for it in self._announced if it.name not in self.refused
                        )
                        self.started.set()
                case Kind.PING:
                    self._control.send(Kind.PONG)
                case Kind.BYE:
                    self._end(f"the receiver says goodbye: {Bye.parse(frame.payload).reason}")
                case Kind.ERROR:
                    self._take_error(Error.parse(frame.payload))
        self._end("the receiver has ended the session")

    def _configure(self, configure: Configure) -> None:
        wanted = self._repertoire.announced(configure.streams)
        if not self._request:
            self._say_what_is_not_asked_for(wanted)
        self._live &= frozenset(wanted)
        for topic in self._announced - set(wanted):
            self._control.send(Kind.CHANNEL_END, ChannelEnd(self._ids[topic]))
        for topic in wanted:
            if topic not in self._announced:
                self._announce(topic)
        self._announced = frozenset(wanted)
        self._request = configure.request
        answers = self._repertoire.answers(configure.streams)
        for stream, answer in answers.items():
            if answer.result == "refused" and answer.reason not in (None, LEFT_OUT):
                self._refuse(stream, str(answer.reason))
        self._control.send(Kind.CONFIGURED, Configured(configure.request, answers))

    def _say_what_is_not_asked_for(self, wanted: Sequence[Topic]) -> None:
        """The first request has all that the receiver's configuration asks for."""
        rest = [topic.name for topic in self._repertoire.topics if topic not in wanted]
        if rest:
            self._say(f"the receiver's configuration does not ask for {', '.join(rest)}")

    def _take_error(self, error: Error) -> None:
        if error.fatal:
            self._end(f"the receiver reports {error.code}: {error.message}")
        for topic in [topic for topic, id in self._ids.items() if id == error.channel]:
            self._refuse(topic.name, error.message)
            self._live -= {topic}

    def _refuse(self, name: str, reason: str) -> None:
        if name not in self.refused:
            self.refused[name] = reason
            self._say(f"{name} is refused: {reason}")

    def _announce(self, topic: Topic) -> None:
        if topic.lane not in self._lanes:
            self._join(topic.lane)
        id = self._ids.setdefault(topic, len(self._ids) + 1)
        self._control.send(
            Kind.CHANNEL,
            Channel(
                id,
                topic.stream,
                topic.role,
                topic.name,
                topic.type,
                topic.qos,
                topic.frame,
                topic.lane,
            ),
        )

    def _tell(self) -> None:
        """STATUS each second, and PING between, so that no side thinks the other dead."""
        status_s = self._began_s
        while not self._finishing.wait(self._welcome.timeouts.ping_s):
            if time.monotonic() >= status_s:
                status_s += _STATUS_PERIOD_S
                self._measure()
                self._status(is_final=False)
            else:
                self._control.send(Kind.PING)

    def _measure(self) -> None:
        sent_ns = time.time_ns()
        lane = self._lanes["time"]
        lane.send(Kind.TIME_REQUEST, _TIME.pack(sent_ns))
        lane.expect(Kind.TIME_REPLY)
        self._round_trips_ns.append(time.time_ns() - sent_ns)

    def _status(self, *, is_final: bool) -> None:
        counts = {topic.name: self._sent.get(topic, 0) for topic in self._ids.copy()}
        channels = {name: ChannelStatus(count, count, {}) for name, count in counts.items()}
        round_trip_ns = min(self._round_trips_ns, default=0)
        clock = ClockStatus("frozen", 0, round_trip_ns // 2, round_trip_ns, epoch=self.epoch)
        uptime_s = time.monotonic() - self._began_s
        self._control.send(Kind.STATUS, Status(is_final, uptime_s, channels, clock))

    def _close(self) -> None:
        for lane in self._lanes.values():
            lane.close()

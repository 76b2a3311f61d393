"""One session of a recording with a receiver."""

import struct
import threading
import time
import uuid
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress

from ml2_receiver.errors import ProtocolError
from ml2_receiver.generated.version import VERSION
from ml2_receiver.printable import printable
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.frame import VERSION as PROTOCOL_VERSION
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import (
    Bye,
    Capabilities,
    Channel,
    ClockStatus,
    Configure,
    Error,
    Hello,
    Joined,
    Start,
    Welcome,
)

from ..errors import PlaybackError
from .answers import LEFT_OUT, Repertoire
from .device import KINDS, Device
from .lane import Destination, Lane

_STATUS_PERIOD_S = 1.0
_ROUND_TRIPS = 15  # one per STATUS, so 15 s
_CLOSING_S = 1.0
_TIME = struct.Struct("<q")
_END_OF_TIME_NS = 1 << 63  # of the header of DATA
# Python's waits take no longer ones than some centuries, which a receiver may ask for.
_LONGEST_S = 3600.0
_SHOWN_CHARACTERS = 60


class PlaybackSession:
    """A session from HELLO to BYE; the caller must call finish().

    One thread answers the receiver's requests, another sends STATUS each second. The stamps are
    those of the recording, so no clock offset is estimated. The time lane carries one exchange per
    second to measure the round trip.

    Args:
        name: the name of the recorded headset.
        log: is called by a thread of this session with lines on refused or unrequested topics.
        over: is set when the receiver ends the session.

    Attributes:
        started: set when START arrives.
        refused: the reasons by stream or topic that is not recorded or that the receiver refuses.
        epoch: the epoch of the stamps; the player increments it after each jump.
        reason: why the receiver ended the session; None while it runs.

    Raises:
        PlaybackError: there is no receiver, or it refuses the session.
    """

    def __init__(
        self,
        destination: Destination,
        name: str,
        repertoire: Repertoire,
        log: Callable[[str], None],
        over: threading.Event,
    ) -> None:
        self.started = threading.Event()
        self.refused: dict[str, str] = {}
        self.epoch = 0
        self.reason: str | None = None
        self._destination, self._over = destination, over
        self._repertoire, self._log = repertoire, log
        self._device = Device(_hello(name, repertoire))
        self._began_s = time.monotonic()
        self._finishing = threading.Event()
        self._lanes: dict[str, Lane] = {}
        self._round_trips_ns: deque[int] = deque(maxlen=_ROUND_TRIPS)
        self._control = self._lanes["control"] = Lane(destination, "control")
        try:
            self._greet()
            for lane in load_table().needed_lanes:
                self._join(lane)
        except BaseException:
            self._close()
            raise
        self._listening = threading.Thread(target=self._guard, args=[self._listen])
        self._reporting = threading.Thread(target=self._guard, args=[self._send_statuses])
        self._listening.start()
        self._reporting.start()

    def is_wanted(self, topic: Topic) -> bool:
        """Returns True if the receiver has requested the topic and takes its messages."""
        return topic in self._device.live and topic.name not in self.refused

    def send(self, topic: Topic, payload: bytes, capture_ns: int) -> None:
        """Sends one message unchanged; blocks until the connection takes it."""
        if not -_END_OF_TIME_NS <= capture_ns < _END_OF_TIME_NS:
            raise PlaybackError(
                f"{topic.name}: expected times before the year 2262, found {capture_ns} ns",
                hint="Leave the topic out with --topics, or repair the recording.",
            )
        header = self._device.data_header(topic, capture_ns, time.time_ns())
        self._lanes[topic.lane.name].send(Kind.DATA, payload, **header)

    def finish(self) -> None:
        """Sends the final STATUS and BYE, if the receiver is still there."""
        self._finishing.set()
        self._reporting.join()
        with suppress(PlaybackError, OSError):
            for lane in self._lanes.values():
                if lane is not self._control:
                    lane.end_output()
            self._status(is_final=True)
            self._control.set_timeout(_CLOSING_S)
            self._control.send(Kind.BYE, Bye("the recording has ended"))
            self._control.end_output()
        self._listening.join()
        self._close()

    def _greet(self) -> None:
        self._control.send(Kind.HELLO, self._device.hello)
        self._device.begin(Welcome.parse(self._control.expect(Kind.WELCOME)))
        self._control.set_timeout(self._dead_s)

    @property
    def _dead_s(self) -> float:
        return min(self._device.welcome.timeouts.dead_s, _LONGEST_S)

    def _join(self, name: str) -> None:
        lane = self._lanes[name] = Lane(self._destination, name)
        lane.send(Kind.JOIN, self._device.join(name))
        Joined.parse(lane.expect(Kind.JOINED))
        lane.set_timeout(self._dead_s)

    def _guard(self, work: Callable[[], None]) -> None:
        try:
            work()
        except (PlaybackError, ProtocolError) as error:
            if threading.current_thread() is not self._listening:
                # The receiver ends all lanes at once, and says why on this one.
                self._listening.join(_CLOSING_S)
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
                    self._configure(Configure.parse(frame.body))
                case Kind.START:
                    if self._device.start(Start.parse(frame.body)):
                        self.started.set()
                case Kind.PING:
                    self._control.send(Kind.PONG)
                case Kind.BYE:
                    self._end(f"the receiver ended the session: {Bye.parse(frame.body).reason}")
                case Kind.ERROR:
                    self._take_error(Error.parse(frame.body))
        self._end("the receiver has ended the session")

    def _configure(self, configure: Configure) -> None:
        topics = self._repertoire.announced(configure.streams)
        answers = self._repertoire.answers(configure.streams)
        if not self._device.is_configured:
            self._log_unrequested(topics)
        for reply in self._device.configure(configure, topics, answers):
            if isinstance(reply, Channel) and reply.lane not in self._lanes:
                self._join(reply.lane)
            self._control.send(KINDS[type(reply)], reply)
        for stream, answer in answers.items():
            if answer.result == "refused" and answer.reason not in (None, LEFT_OUT):
                self._refuse(stream, str(answer.reason))

    def _log_unrequested(self, topics: Sequence[Topic]) -> None:
        """Logs the topics that the first request, the receiver's configuration, leaves out."""
        rest = [topic.name for topic in self._repertoire.topics if topic not in topics]
        if rest:
            self._log(f"the receiver's configuration does not ask for {', '.join(rest)}")

    def _take_error(self, error: Error) -> None:
        if error.fatal:
            self._end(f"the receiver reports {error.code}: {error.message}")
        for topic in self._device.refuse(error.channel):
            self._refuse(topic.name, error.message)

    def _refuse(self, name: str, reason: str) -> None:
        if name not in self.refused:
            self.refused[name] = reason
            self._log(f"{name} is refused: {reason}")

    def _send_statuses(self) -> None:
        """Sends STATUS each second, and PING in between to keep the session alive."""
        status_s = self._began_s
        ping_s = min(self._device.welcome.timeouts.ping_s, _LONGEST_S)
        while not self._finishing.wait(ping_s):
            if time.monotonic() >= status_s:
                status_s += _STATUS_PERIOD_S
                self._measure_round_trip()
                self._status(is_final=False)
            else:
                self._control.send(Kind.PING)

    def _measure_round_trip(self) -> None:
        sent_ns = time.time_ns()
        lane = self._lanes["time"]
        lane.send(Kind.TIME_REQUEST, _TIME.pack(sent_ns))
        lane.expect(Kind.TIME_REPLY)
        self._round_trips_ns.append(time.time_ns() - sent_ns)

    def _status(self, *, is_final: bool) -> None:
        round_trip_ns = min(self._round_trips_ns, default=0)
        clock = ClockStatus("frozen", 0, round_trip_ns // 2, round_trip_ns, epoch=self.epoch)
        uptime_s = time.monotonic() - self._began_s
        self._control.send(Kind.STATUS, self._device.status(uptime_s, clock, is_final=is_final))

    def _close(self) -> None:
        for lane in self._lanes.values():
            lane.close()


def _hello(name: str, repertoire: Repertoire) -> Hello:
    try:
        return Hello(
            versions=[PROTOCOL_VERSION],
            device_id=f"recording of {name}",
            instance_id=uuid.uuid4().hex,
            name=name,
            software=f"ml2-receiver play {VERSION}",
            capabilities=Capabilities(repertoire.streams),
            permissions={},
        )
    except ValueError as error:
        raise PlaybackError(
            f"the recording is of a headset that no receiver accepts: {error}, found"
            f" {printable(name, _SHOWN_CHARACTERS)!r}",
            hint="Its topic `config` is damaged or not of `ml2-receiver record`. `ros2 bag play`"
            " publishes the topics.",
        ) from error

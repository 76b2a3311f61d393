"""One device from WELCOME to the end of its last lane, as a state machine without I/O."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from ..errors import ErrorCode, LinkTestError, ProtocolError
from ..wire.frame import Frame
from ..wire.json_body import JsonBody
from ..wire.kinds import CONTROL, Kind
from ..wire.messages import (
    Bye,
    Channel,
    ChannelEnd,
    Configure,
    Configured,
    Error,
    Event,
    Hello,
    Join,
    Joined,
    Status,
)
from .actions import Act, Ending, Log, Send, close, error_body
from .channels import Channels
from .connection import Connection
from .link_tests import LinkTests
from .report import OpeningsReport, Report, State, TopicReport
from .settings import ReceiverSettings
from .sink import Applied
from .statistics import Instance, TopicStatistics
from .stream_state import changes_in_words
from .streams import DesiredStreams, Streams
from .tickets import Tickets, new_token


class Session:
    """The lanes, time-outs and end of one session; `streams` negotiates what runs.

    Methods raise ProtocolError when the device broke the protocol; `now_s` is monotonic time. Not
    thread-safe.

    Args:
        received: the messages of `instance` that arrived before, by topic; None if it is new.
        act: takes each action that the session requests; the first one sends WELCOME.
    """

    def __init__(
        self,
        hello: Hello,
        control: Connection,
        instance: Instance,
        received: Mapping[str, int] | None,
        settings: ReceiverSettings,
        act: Act,
        now_s: float,
    ) -> None:
        self.hello = hello
        self.id = new_token()
        self.state = State.CONNECTED
        self.streams = Streams(settings.table, instance.custom, settings.frame_prefix)
        self.instance = instance
        self.link_tests = LinkTests(instance.received_bytes)
        self.status: Status | None = None
        self.skipped_frames = 0
        self._settings, self._act, self.control = settings, act, control
        self.openings = control.openings = settings.openings(hello, instance.books)
        of_channels = settings.table.custom_topics, self.streams, control, instance, self.openings
        self._channels = Channels(*of_channels, act)
        self._tickets = Tickets(settings.lanes(self.openings))
        self._open = {control}
        self._began_s = self._last_received_s = self._last_sent_s = now_s
        self._lane_ended_s: float | None = None
        self._bye_s: float | None = None
        self._handlers: dict[int, Callable[[bytearray, float], None]] = {
            Kind.CHANNEL: lambda body, now_s: self._channel(Channel.parse(body), now_s),
            Kind.CHANNEL_END: lambda body, _: self._channels.end(ChannelEnd.parse(body)),
            Kind.CONFIGURED: lambda body, _: self._configured(Configured.parse(body)),
            Kind.STATUS: lambda body, _: self._status(Status.parse(body)),
            Kind.FILLER: lambda body, now_s: self.link_tests.filled(len(body), now_s),
            Kind.PING: lambda _, now_s: self._send(Kind.PONG, None, now_s),
            Kind.PONG: lambda *_: None,
            Kind.EVENT: lambda body, _: self._log(Event.parse(body).text_and_age),
            Kind.BYE: lambda body, now_s: self._bye(Bye.parse(body), now_s),
        }
        control.lane = CONTROL
        welcome = settings.welcome(self.id, self._tickets.by_lane, received, self.openings)
        self._send(Kind.WELCOME, welcome, now_s)

    def __contains__(self, connection: Connection) -> bool:
        return connection in self._open

    @property
    def is_over(self) -> bool:
        """True if the session has ended and all lanes but control are read to their end."""
        return self.state is not State.CONNECTED and self._open <= {self.control}

    def join(self, connection: Connection, join: Join) -> None:
        """Adds a connection as the lane that its JOIN names."""
        if join.session != self.id:
            raise ProtocolError(ErrorCode.TICKET, "there is no such session")
        if connection.peer != self.control.peer:
            raise ProtocolError(ErrorCode.TICKET, "the session is another device's")
        if self.state is not State.CONNECTED:
            raise ProtocolError(ErrorCode.TICKET, f"no lane {join.lane!r} can be joined")
        self._tickets.use(join.lane, join.ticket)
        self._open.add(connection)
        connection.lane = self._settings.table.lane(join.lane)
        connection.routes = self.streams.routes.get(join.lane, {})
        connection.openings = self.openings and self.openings.joined(join.lane)
        self._act(Send(connection, Kind.JOINED, Joined(join.lane)))

    @property
    def _is_complete(self) -> bool:
        return self._tickets.are_used(self._settings.table.needed_lanes)

    def _send(self, kind: Kind, body: JsonBody | None, now_s: float) -> None:
        """Sends a frame on control."""
        self._last_sent_s = now_s
        self._act(Send(self.control, kind, body))

    def received(self, connection: Connection, frame: Frame, now_s: float) -> None:
        """Handles a frame of one of the lanes, other than DATA and TIME_REQUEST."""
        if self.state is not State.CONNECTED:
            return
        if connection is self.control:
            self._last_received_s = now_s
        if frame.header.kind == Kind.ERROR:
            self._error(connection, Error.parse(frame.body))
        elif handle := self._handlers.get(frame.header.kind):
            handle(frame.body, now_s)
        elif self.openings is not None and (answers := self.openings.answers(frame)) is not None:
            for kind, body in answers:
                self._send(kind, body, now_s)
        else:
            self.skipped_frames += 1

    def _channel(self, channel: Channel, now_s: float) -> None:
        if (reason := self._channels.announce(channel)) is not None:
            self.topic_refused(channel.id, reason, now_s)
        elif self.streams.is_answered:
            self._apply()

    def topic_refused(self, channel: int, reason: str, now_s: float) -> None:
        """Tells user and device that the topic of a channel cannot be opened."""
        self._log(reason)
        error = error_body(ProtocolError(ErrorCode.CHANNEL, reason))
        self._send(Kind.ERROR, replace(error, fatal=False, channel=channel), now_s)

    def _configured(self, configured: Configured) -> None:
        known = self.streams.answers
        self.streams.configured(configured)
        for id, answer in self.streams.answers.items():
            if answer.result != "applied" and answer != known.get(id):
                self._log(f"{id} {answer.result}: {answer.reason!r}")
        running = [id for id, answer in configured.streams.items() if answer.result != "refused"]
        self._log(f"streams: {', '.join(running) or 'none'}")
        self._apply()

    def _apply(self) -> None:
        answers, topics = self.streams.answers, self.streams.topics
        hello, states = self.hello, self.streams.states(self.status)
        self._act(Applied(hello.name, self.id, answers, topics, states, hello.device_id))

    def advance(self, desired: DesiredStreams, now_s: float) -> None:
        """Sends CONFIGURE or START if one of them is due."""
        if self.state is not State.CONNECTED or not self._is_complete:
            return
        due = self.streams.next_message(desired)
        if due is not None:
            kind = Kind.CONFIGURE if isinstance(due, Configure) else Kind.START
            self._send(kind, due, now_s)

    def test_link(self, now_s: float) -> None:
        """Starts a link test; report() has the result.

        Raises:
            LinkTestError: no device is connected, a test is running, or the last got no answer.
        """
        if self.state is not State.CONNECTED or not self._is_complete:
            raise LinkTestError("no headset is connected")
        self._send(Kind.LINK_TEST, self.link_tests.ask(now_s), now_s)

    def _status(self, status: Status) -> None:
        before, now = self.streams.states(self.status), self.streams.states(status)
        self.status = status
        for text in changes_in_words(before, now):
            self._log(text)
        if now != before and self.streams.is_answered:
            self._apply()
        if any(it.state == "available" != before[id].state for id, it in now.items()):
            self.streams.renegotiate()

    def _error(self, connection: Connection, error: Error) -> None:
        text = f"the device reports {error.code!r}: {error.message!r}"
        if error.fatal:
            self.finish(State.LOST, text)
        else:
            self._log(text)

    def _bye(self, bye: Bye, now_s: float) -> None:
        self._log(f"says goodbye: {bye.reason!r}")
        self._bye_s = now_s
        self._end_when_read()

    def closed(self, connection: Connection, fault: str | None, now_s: float) -> None:
        """Removes a connection that has ended; `fault` is None if it ended between two frames."""
        self._open.discard(connection)
        self._channels.tell(self._log)
        if self.state is not State.CONNECTED:
            return
        if fault is not None and (self._bye_s is None or connection is not self.control):
            self.finish(State.LOST, f"lane {connection.name!r}: {fault}")
        elif self._bye_s is not None:
            self._end_when_read()
        elif connection is self.control:
            self.finish(State.LOST, "control ended without BYE")
        elif self._lane_ended_s is None:
            self._lane_ended_s = now_s

    def _end_when_read(self) -> None:
        if self._open <= {self.control}:
            self.finish(State.ENDED, "every lane is read")

    def tick(self, now_s: float, stood_still_s: float) -> None:
        """Checks the time-outs but for `stood_still_s`, and sends PING if it is due."""
        self._last_received_s = min(now_s, self._last_received_s + stood_still_s)
        if self.state is not State.CONNECTED:
            return
        limits = self._settings.limits
        if self._bye_s is not None:
            if now_s - self._bye_s > limits.dead_s:
                self.finish(State.ENDED, "some lanes did not end after BYE")
        elif now_s - self._last_received_s > limits.dead_s:
            self.fail(ProtocolError(ErrorCode.TIMEOUT, f"silent for {limits.dead_s} s"))
        elif not self._is_complete and now_s - self._began_s > limits.handshake_s:
            self.fail(ProtocolError(ErrorCode.TIMEOUT, "time and sensors were not joined"))
        elif self._lane_ended_s is not None and now_s - self._lane_ended_s > limits.dead_s:
            self.finish(State.LOST, "a lane ended without BYE", Bye("a lane ended"))
        elif now_s - self._last_sent_s >= limits.ping_s:
            self._send(Kind.PING, None, now_s)
        self._hold_to_rules(now_s)

    def _hold_to_rules(self, now_s: float) -> None:
        for channel, reason in self._channels.withdrawn():
            self.topic_refused(channel, reason, now_s)
        for closed in self.openings.ended() if self.openings else []:
            self._send(Kind.CLOSED, closed, now_s)
        self._channels.tell(self._log)

    def fail(self, error: ProtocolError) -> None:
        """Ends the session with an ERROR on control."""
        self.finish(State.LOST, str(error), error_body(error))

    def finish(self, state: State, reason: str, closing_message: Bye | Error | None = None) -> None:
        """Ends the session, as ENDED if the device sent BYE; what has arrived is still read."""
        if self.state is not State.CONNECTED:
            return
        self.state = State.ENDED if self._bye_s is not None else state
        self._log(f"session {self.state.value}: {reason}")
        if self.openings is not None:
            self.openings.finish()
        if closing_message is not None:
            kind = Kind.BYE if isinstance(closing_message, Bye) else Kind.ERROR
            self._act(Send(self.control, kind, closing_message))
        for connection in self._open:
            has_message = closing_message is not None and connection is self.control
            close(self._act, connection, Ending.DISCARD if has_message else Ending.DRAIN)

    def report(self, now_s: float) -> Report:
        """Returns a snapshot of the session."""
        status = self.status
        return Report(
            state=self.state,
            headset=self.hello.name,
            device_id=self.hello.device_id,
            clock=status.clock if status else None,
            skipped_frames=self.skipped_frames,
            is_final=bool(status and status.final),
            software=self.hello.software,
            capabilities=self.hello.capabilities.streams,
            permissions=self.hello.permissions,
            answers=self.streams.answers,
            link_test=self.link_tests.report(now_s),
            thermal=status.thermal if status else None,
            streams=self.streams.states(self.status),
            conditions=(status.conditions if status else None) or {},
            openings=self.openings.report(status) if self.openings else OpeningsReport(),
            topics=[self._topic_report(*topic) for topic in self.instance.topics.items()],
        )

    def _topic_report(self, name: str, statistics: TopicStatistics) -> TopicReport:
        topic = self.streams.topic(name)
        device = self.status.channels.get(name) if self.status else None
        own = device and statistics.of_this_receiver(device)
        return TopicReport(topic, statistics, own, self.streams.is_running(topic))

    def _log(self, text: str) -> None:
        self._act(Log(f"{self.hello.name!r}: {text}", "session"))

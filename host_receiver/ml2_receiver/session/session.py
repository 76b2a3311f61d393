"""One device from WELCOME to the end of its last lane, as a state machine without I/O."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from ..errors import ErrorCode, LinkTestError, ProtocolError, PublishError
from ..table.stream_table import Topic
from ..wire.frame import Frame
from ..wire.json_body import JsonBody
from ..wire.kinds import Kind
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
    StreamStatus,
)
from .connection import Connection, Route
from .context import Context, Ending, Send, close, error_body
from .report import Report, State, TopicReport
from .sink import Applied, refuse
from .statistics import Instance, TopicStatistics
from .stream_state import changes_in_words, stream_states
from .streams import DesiredStreams, Streams
from .throughput import LinkTrial
from .tickets import Tickets, new_token

_NEEDED_LANES = ("time", "sensors")
_TEST_LANE = "link_test"


class Session:
    """The lanes, time-outs and end of one session; `streams` negotiates what runs.

    Methods raise ProtocolError when the device broke the protocol. Not thread-safe.

    Args:
        log: logs a line for the user.
    """

    def __init__(
        self,
        hello: Hello,
        control: Connection,
        instance: Instance,
        context: Context,
        log: Callable[[str], None],
    ) -> None:
        self.hello = hello
        self.id = new_token()
        self.state = State.CONNECTED
        settings = context.settings
        self.streams = Streams(settings.table, instance.custom, settings.frame_prefix)
        self.instance = instance
        self.link = LinkTrial(context.clock, instance.received_bytes)
        self.status: Status | None = None
        self.skipped_frames = 0
        self._context, self._log = context, log
        self.control = control
        self._tickets = Tickets((*_NEEDED_LANES, _TEST_LANE, *settings.table.image_lanes))
        self._open = {control}
        self._began_s = self._last_received_s = self._last_sent_s = context.clock()
        self._lane_ended_s: float | None = None
        self._bye_s: float | None = None
        self._handlers: dict[int, Callable[[bytearray], None]] = {
            Kind.CHANNEL: lambda body: self._channel(Channel.parse(body)),
            Kind.CHANNEL_END: lambda body: self.streams.end(ChannelEnd.parse(body)),
            Kind.CONFIGURED: lambda body: self._configured(Configured.parse(body)),
            Kind.STATUS: self._status,
            Kind.FILLER: lambda body: self.link.filled(len(body)),
            Kind.PING: lambda _: self.send(Kind.PONG),
            Kind.PONG: lambda _: None,
            Kind.EVENT: lambda body: self._log_event(Event.parse(body).text_and_age),
            Kind.BYE: lambda body: self._bye(Bye.parse(body)),
        }
        control.lane = "control"

    def __contains__(self, connection: Connection) -> bool:
        return connection in self._open

    @property
    def is_over(self) -> bool:
        """True if the session has ended and all lanes but control are read to their end."""
        return self.state is not State.CONNECTED and self._open <= {self.control}

    def welcome(self, received: dict[str, int] | None) -> None:
        """Sends WELCOME; `received` has the messages received by topic, None for a new instance."""
        settings = self._context.settings
        self.send(Kind.WELCOME, settings.welcome(self.id, self._tickets.by_lane, received))

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
        connection.lane = join.lane
        connection.routes = self.streams.routes.get(join.lane, {})
        self._context.act(Send(connection, Kind.JOINED, Joined(join.lane)))

    @property
    def _is_complete(self) -> bool:
        return self._tickets.are_used(_NEEDED_LANES)

    def send(self, kind: Kind, body: JsonBody | None = None) -> None:
        """Sends a frame on control."""
        self._last_sent_s = self._context.clock()
        self._context.act(Send(self.control, kind, body))

    def received(self, connection: Connection, frame: Frame) -> None:
        """Handles a frame of one of the lanes, other than DATA and TIME_REQUEST."""
        if self.state is not State.CONNECTED:
            return
        if connection is self.control:
            self._last_received_s = self._context.clock()
        if frame.header.kind == Kind.ERROR:
            self._error(connection, Error.parse(frame.body))
        elif handle := self._handlers.get(frame.header.kind):
            handle(frame.body)
        else:
            self.skipped_frames += 1

    def _channel(self, channel: Channel) -> None:
        topic = self.streams.announce(channel)
        try:
            publish = self._context.sink.open(topic)
        except PublishError as refusal:
            publish = refuse
            self._log_event(str(refusal))
            error = error_body(ProtocolError(ErrorCode.CHANNEL, str(refusal)))
            self.send(Kind.ERROR, replace(error, fatal=False, channel=channel.id))
        statistics = self.instance.topics.setdefault(topic.name, TopicStatistics())
        self.streams.route(channel.id, Route(publish, statistics))
        if self.streams.is_answered:
            self._apply()

    def _configured(self, configured: Configured) -> None:
        known = self.streams.answers
        self.streams.configured(configured)
        for id, answer in self.streams.answers.items():
            if answer.result != "applied" and answer != known.get(id):
                self._log_event(f"{id} {answer.result}: {answer.reason!r}")
        running = [id for id, answer in configured.streams.items() if answer.result != "refused"]
        self._log_event(f"streams: {', '.join(running) or 'none'}")
        self._apply()

    def _apply(self) -> None:
        self._context.sink.configured(
            Applied(
                self.hello.name,
                self.id,
                self.streams.answers,
                self.streams.topics,
                self._stream_states(),
            )
        )

    def _stream_states(self) -> dict[str, StreamStatus]:
        return stream_states(self.streams.answers, self._reported)

    @property
    def _reported(self) -> Mapping[str, StreamStatus]:
        return (self.status and self.status.streams) or {}

    def advance(self, desired: DesiredStreams) -> None:
        """Sends CONFIGURE or START if one of them is due."""
        if self.state is not State.CONNECTED or not self._is_complete:
            return
        due = self.streams.next_message(desired)
        if due is not None:
            self.send(Kind.CONFIGURE if isinstance(due, Configure) else Kind.START, due)

    def test_link(self) -> None:
        """Starts a link test; report() has the result.

        Raises:
            LinkTestError: the device is not connected, a test is running, or the last test was not
                answered.
        """
        if self.state is not State.CONNECTED or not self._is_complete:
            raise LinkTestError("no headset is connected")
        self.send(Kind.LINK_TEST, self.link.ask())

    def _status(self, body: bytearray) -> None:
        known, before = self._reported, self._stream_states()
        self.status = Status.parse(body)
        now = self._stream_states()
        for text in changes_in_words(before, now):
            self._log_event(text)
        if now != before and self.streams.is_answered:
            self._apply()
        available = {id for id, it in now.items() if it.state == "available"}
        if any(id not in known or known[id].state != "available" for id in available):
            self.streams.renegotiate()

    def _error(self, connection: Connection, error: Error) -> None:
        text = f"the device reports {error.code!r}: {error.message!r}"
        if error.fatal:
            self.finish(State.LOST, text)
        else:
            self._log_event(text)

    def _bye(self, bye: Bye) -> None:
        self._log_event(f"says goodbye: {bye.reason!r}")
        self._bye_s = self._context.clock()
        self._end_when_read()

    def closed(self, connection: Connection, fault: str | None) -> None:
        """Removes a connection that has ended; `fault` is None if it ended between two frames."""
        self._open.discard(connection)
        if self.state is not State.CONNECTED:
            return
        if fault is not None and (self._bye_s is None or connection is not self.control):
            self.finish(State.LOST, f"lane {connection.lane!r}: {fault}")
        elif self._bye_s is not None:
            self._end_when_read()
        elif connection is self.control:
            self.finish(State.LOST, "control ended without BYE")
        elif self._lane_ended_s is None:
            self._lane_ended_s = self._context.clock()

    def _end_when_read(self) -> None:
        if self._open <= {self.control}:
            self.finish(State.ENDED, "every lane is read")

    def tick(self) -> None:
        """Checks the time-outs, and sends PING if it is due."""
        if self.state is not State.CONNECTED:
            return
        now, limits = self._context.clock(), self._context.settings.limits
        if self._bye_s is not None:
            if now - self._bye_s > limits.dead_s:
                self.finish(State.ENDED, "some lanes did not end after BYE")
        elif now - self._last_received_s > limits.dead_s:
            self.fail(ProtocolError(ErrorCode.TIMEOUT, f"silent for {limits.dead_s} s"))
        elif not self._is_complete and now - self._began_s > limits.handshake_s:
            self.fail(ProtocolError(ErrorCode.TIMEOUT, "time and sensors were not joined"))
        elif self._lane_ended_s is not None and now - self._lane_ended_s > limits.dead_s:
            self.finish(State.LOST, "a lane ended without BYE", Bye("a lane ended"))
        elif now - self._last_sent_s >= limits.ping_s:
            self.send(Kind.PING)

    def fail(self, error: ProtocolError) -> None:
        """Ends the session with an ERROR on control."""
        self.finish(State.LOST, str(error), error_body(error))

    def finish(self, state: State, reason: str, closing_message: Bye | Error | None = None) -> None:
        """Ends the session, as ENDED if the device sent BYE; what has arrived is still read."""
        if self.state is not State.CONNECTED:
            return
        self.state = State.ENDED if self._bye_s is not None else state
        self._log_event(f"session {self.state.value}: {reason}")
        if closing_message is not None:
            self.send(Kind.BYE if isinstance(closing_message, Bye) else Kind.ERROR, closing_message)
        for connection in self._open:
            has_message = closing_message is not None and connection is self.control
            close(self._context, connection, Ending.DISCARD if has_message else Ending.DRAIN)

    def report(self) -> Report:
        """Returns a snapshot of the session. Thread-safe."""
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
            link=self.link.report(),
            thermal=status.thermal if status else None,
            streams=self._stream_states(),
            topics=[
                self._topic_report(self.streams.topic(name), counts)
                for name, counts in list(self.instance.topics.items())
            ],
        )

    def _topic_report(self, topic: Topic, statistics: TopicStatistics) -> TopicReport:
        device = self.status.channels.get(topic.name) if self.status else None
        return TopicReport(topic, statistics, device, self.streams.is_running(topic))

    def _log_event(self, text: str) -> None:
        self._log(f"{self.hello.name!r}: {text}")

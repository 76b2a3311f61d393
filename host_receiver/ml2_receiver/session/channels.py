"""The channels of a session: where their DATA goes, what an app may publish, and its wills."""

from collections.abc import Callable, Iterator

from ..errors import ErrorCode, ProtocolError
from ..table.stream_table import CustomTopics, Topic
from ..wire.messages import Channel, ChannelEnd
from .actions import Act, EndWill, Open
from .connection import Connection, Route
from .openings import Openings
from .sink import refuse
from .statistics import Instance
from .streams import Streams
from .will import Will


class Channels:
    """Not thread-safe.

    Args:
        rules: for the topics that apps name.
        openings: have the user's rules for absolute names; None lets apps name plain topics alone.
    """

    def __init__(
        self,
        rules: CustomTopics,
        streams: Streams,
        control: Connection,
        instance: Instance,
        openings: Openings | None,
        act: Act,
    ) -> None:
        self._rules, self._streams, self._control = rules, streams, control
        self._instance, self._openings, self._act = instance, openings, act
        self._held_to = openings and openings.rules
        self._routes: dict[int, tuple[Topic, Route]] = {}
        self._told: dict[Will, int] = {}

    def announce(self, channel: Channel) -> str | None:
        """Takes a CHANNEL, and returns why the app may not publish the topic; None if it may."""
        topic = self._streams.announce(channel)
        is_custom = topic.stream == self._rules.stream
        will = channel.will if is_custom else None
        is_plain = will is None and topic == self._rules.topic(topic.name, topic.type)
        if is_custom and self._openings is None and not (is_plain and topic.name[0] != "/"):
            what = f"{topic.name} is absolute, latched, large or has a will"
            raise ProtocolError(ErrorCode.CHANNEL, f"{what}, and WELCOME has no ros")
        last = Will(topic.name, will.message, will.silent_ms / 1000) if will else None
        route = Route(refuse, self._instance.statistics(topic.name), last)
        self._routes[channel.id] = topic, route
        self._streams.route(channel.id, route)
        if (reason := self._forbidden(topic)) is None:
            self._act(Open(self._control, channel.id, topic, route))
        return reason

    def _forbidden(self, topic: Topic) -> str | None:
        is_absolute = topic.stream == self._rules.stream and topic.name.startswith("/")
        return self._openings.forbidden(topic) if is_absolute and self._openings else None

    def end(self, end: ChannelEnd) -> None:
        """Takes a CHANNEL_END."""
        self._streams.end(end)
        self._end_will(end.id)

    def _end_will(self, channel: int) -> None:
        if (will := self._routes[channel][1].will) is not None:
            self._act(EndWill(will))

    def withdrawn(self) -> Iterator[tuple[int, str]]:
        """Ends the topics that the rules have no more, and returns why, by channel."""
        if self._openings is None or (rules := self._openings.rules) == self._held_to:
            return
        self._held_to = rules
        for id, (topic, route) in self._routes.items():
            if route.publish is not refuse and (reason := self._forbidden(topic)) is not None:
                self._end_will(id)
                route.publish = refuse
                yield id, reason

    def tell(self, log: Callable[[str], None]) -> None:
        """Tells the user which wills were published since the last time."""
        for will in (route.will for _, route in self._routes.values()):
            if will is not None and will.published > self._told.get(will, 0):
                self._told[will] = will.published
                log(will.text)

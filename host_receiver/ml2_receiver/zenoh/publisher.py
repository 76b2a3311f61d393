"""One topic on Zenoh."""

import threading
import time
from collections.abc import Callable

import zenoh

from ..errors import PublishError
from .names import Node, TopicName, attachment, gid

_HEARTBEAT_S = 0.5  # as in rmw_zenoh


class ZenohPublisher:
    """Publishes payloads on one topic, until close(). Thread-safe.

    A full queue drops the message: Zenoh does not say so, but each message carries its number,
    so that a subscriber sees what it lacks.

    Args:
        number: of the publisher within its session, from 1.
        priority: which messages go first where a link is slow.
        demand_changed: called by a thread of Zenoh when the first subscriber has come, or the last
            gone; returns at once.

    Raises:
        PublishError: Zenoh does not take the name.
    """

    def __init__(
        self,
        session: zenoh.Session,
        node: Node,
        number: int,
        topic: TopicName,
        priority: zenoh.Priority,
        demand_changed: Callable[[], None],
    ) -> None:
        self.published = 0
        self._lock = threading.Lock()  # Zenoh undeclares no publisher that is publishing
        self._is_open = True
        self._has_subscriber = threading.Event()
        token, key = node.publisher_token(number, topic), topic.key(node.domain)
        self._gid = gid(token)
        try:
            if topic.qos.durability == "transient_local":
                self._has_subscriber.set()  # Zenoh does not say it for these
                self._publisher: zenoh.Publisher | zenoh.ext.AdvancedPublisher = _latched(
                    session, key, topic.qos.depth, priority
                )
            else:
                self._publisher = _volatile(session, key, priority)
                self._watch_subscribers(self._publisher, demand_changed)
            self._token = session.liveliness().declare_token(token)
        except zenoh.ZError as error:
            raise PublishError(f"{topic.name} is not published on Zenoh: {error}") from error

    @property
    def has_subscriber(self) -> bool:
        """True if a subscriber is known; always True for a latched topic."""
        return self._has_subscriber.is_set()

    def publish(self, payload: bytes | bytearray) -> None:
        """Publishes a payload, which may be used again afterwards; nothing after close().

        Raises:
            PublishError: Zenoh does not take it.
        """
        with self._lock:
            if not self._is_open:
                return
            number = self.published + 1
            if self.has_subscriber:  # else Zenoh would copy the payload and drop it
                self._put(payload, attachment(number, time.time_ns(), self._gid))
            self.published = number

    def _put(self, payload: bytes | bytearray, attachment: bytes) -> None:
        try:
            self._publisher.put(payload, attachment=attachment)
        except zenoh.ZError as error:
            raise PublishError(f"Zenoh: {error}") from error

    def close(self) -> None:
        """Ends the topic; the session must be open."""
        with self._lock:
            if self._is_open:
                self._is_open = False
                self._token.undeclare()
                self._publisher.undeclare()  # type: ignore[no-untyped-call]

    def _watch_subscribers(
        self, publisher: zenoh.Publisher, demand_changed: Callable[[], None]
    ) -> None:
        def changed(status: zenoh.MatchingStatus) -> None:
            (self._has_subscriber.set if status.matching else self._has_subscriber.clear)()
            demand_changed()

        # Direct, since otherwise Zenoh's binding starts a thread for each topic
        publisher.declare_matching_listener(zenoh.handlers.Callback(changed, indirect=False))


def _volatile(session: zenoh.Session, key: str, priority: zenoh.Priority) -> zenoh.Publisher:
    return session.declare_publisher(
        key,
        congestion_control=zenoh.CongestionControl.DROP,
        priority=priority,
        express=False,
        reliability=zenoh.Reliability.RELIABLE,
    )


def _latched(
    session: zenoh.Session, key: str, depth: int, priority: zenoh.Priority
) -> zenoh.ext.AdvancedPublisher:
    return zenoh.ext.declare_advanced_publisher(
        session,
        key,
        congestion_control=zenoh.CongestionControl.DROP,
        priority=priority,
        express=False,
        reliability=zenoh.Reliability.RELIABLE,
        cache=zenoh.ext.CacheConfig(max_samples=depth),
        publisher_detection=True,
        sample_miss_detection=zenoh.ext.MissDetectionConfig(
            heartbeat=None, sporadic_heartbeat=_HEARTBEAT_S
        ),
    )

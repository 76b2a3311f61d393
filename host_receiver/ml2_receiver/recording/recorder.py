"""Records what is received, on a thread of its own."""

import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fnmatch import fnmatchcase
from queue import Empty, SimpleQueue

from ..errors import PublishError
from ..session.report import Report
from ..session.sink import Applied, Publish
from ..stop_limit import STOP_LIMIT
from ..table.stream_table import StreamTable, Topic
from ..topics.config_topic import config_text
from ..topics.plain_messages import encode_string
from .bag_topic import BagTopic
from .bag_writer import BagWriter
from .losses import Losses

QUEUE_BYTES = 256 << 20  # one to two seconds of every stream at once
_MESSAGE_BYTES = 256  # what Python needs for a queued message beside its payload
# A kill may cost 0.5 s; the rest is for a write that takes its time, and for a busy machine.
_FLUSH_PERIOD_S = 0.2
_METADATA_PERIOD_S = 5.0

type _Job = tuple[BagTopic, int, bytes | None]  # without payload: a new topic


@dataclass(frozen=True)
class Progress:
    """The progress of a recording.

    Attributes:
        duration_s: from its first message to its last.
        file_bytes: what a kill would leave.
        dropped: messages that arrived, but that the recording did not take, by topic.
        lost: messages of its topics that never arrived at this receiver, by topic.
    """

    duration_s: float
    file_bytes: int
    messages: int
    dropped: Mapping[str, int]
    lost: Mapping[str, int]


class Recorder:
    """A Sink that writes a recording; the topics `config` and `log` are recorded too.

    Messages have the time at which they were handed over here, as `log_time` and `publish_time`,
    like in a bag of ros2 bag. Each payload is copied into a queue, since its buffer is used
    again; while the queue is full messages are dropped, counted and refused with PublishError.
    The same happens to all once the disk has failed. close() must be called.

    Args:
        writer: used by the thread alone from now on.
        prefix: of the relative topics.
        on_failure: called once, by the thread, when the disk fails, with what it said.
        patterns: of the topics to record, as in a shell, absolute or relative to the prefix; none
            is all. `config` and `log` are recorded in any case.
        before: the session there is already.
    """

    def __init__(
        self,
        writer: BagWriter,
        table: StreamTable,
        prefix: str,
        on_failure: Callable[[str], None],
        queue_bytes: int = QUEUE_BYTES,
        patterns: Sequence[str] = (),
        before: Report | None = None,
    ) -> None:
        self.failure: str | None = None
        self._writer, self._table, self._prefix = writer, table, prefix
        self._on_failure, self._queue_bytes = on_failure, queue_bytes
        self._patterns, self._losses = patterns, Losses(prefix, before)
        self._lock = threading.Lock()
        self._queued_bytes = 0
        self._dropped: Counter[str] = Counter()
        self._written: Counter[str] = Counter()
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._known: set[BagTopic] = set()
        self._live: frozenset[BagTopic] = frozenset()
        self._own = {
            topic.name: self._open(self._bag_topic(f"{prefix}/{topic.name}", topic.type, topic.qos))
            for topic in table.receiver_topics
        }
        self._is_closing = False
        self._thread = threading.Thread(target=self._run, name="recorder")
        self._thread.start()

    @property
    def progress(self) -> Progress:
        """The present progress; any thread may read it."""
        with self._lock:
            dropped = dict(self._dropped)
        lost = {name: n for name, n in self._losses.by_topic().items() if self._is_wanted(name)}
        messages = sum(dict(self._written).values())
        duration_s = self._writer.metadata.duration_ns / 1e9
        return Progress(duration_s, self._writer.flushed_bytes, messages, dropped, lost)

    def close(self) -> None:
        """Writes what is queued, and the index; nothing may be called after but `progress`."""
        self._is_closing = True
        self._jobs.put(None)
        self._thread.join()

    def hear(self, report: Report | None) -> None:
        """Takes what the session there is says of losses."""
        self._losses.update(report)

    def open(self, topic: Topic) -> Publish:
        name = topic.full_name(self._prefix)
        if not self._is_wanted(name):
            return lambda _: None
        return self._open(self._bag_topic(name, topic.type, topic.qos))

    def configured(self, applied: Applied) -> None:
        names = {topic.full_name(self._prefix) for topic in applied.topics}
        names |= {f"{self._prefix}/{name}" for name in self._own}
        self._live = frozenset(topic for topic in self._live if topic.name in names)
        self._say("config", config_text(applied, self._prefix))

    def event(self, text: str) -> None:
        self._say("log", text)

    def session_ended(self, report: Report) -> None:
        self.hear(report)

    def _is_wanted(self, name: str) -> bool:
        relative = name.removeprefix(f"{self._prefix}/")
        return not self._patterns or any(
            fnmatchcase(it, pattern) for pattern in self._patterns for it in (name, relative)
        )

    def _bag_topic(self, name: str, type: str, qos: str) -> BagTopic:
        return BagTopic(name, type, self._table.qos[qos])

    def _open(self, topic: BagTopic) -> Publish:
        if topic not in self._known:
            self._known.add(topic)
            self._jobs.put((topic, 0, None))
        self._live |= {topic}

        def publish(payload: bytearray) -> None:
            if topic in self._live:
                self._enqueue(topic, time.time_ns(), payload)

        return publish

    def _say(self, name: str, text: str) -> None:
        with suppress(PublishError):  # it is counted
            self._own[name](bytearray(encode_string(text)))

    def _enqueue(self, topic: BagTopic, time_ns: int, payload: bytearray) -> None:
        size = len(payload) + _MESSAGE_BYTES
        with self._lock:
            if self.failure is not None or self._queued_bytes + size > self._queue_bytes:
                self._dropped[topic.name] += 1
                raise PublishError(self.failure or "the disk is too slow for the recording")
            self._queued_bytes += size
        self._jobs.put((topic, time_ns, bytes(payload)))

    def _run(self) -> None:
        try:
            self._write_jobs()
            self._writer.close()
        except OSError as error:
            self._fail(error.strerror or str(error))
        except BaseException as error:
            self._fail(f"of a fault of ours, {error!r}")
            raise

    def _write_jobs(self) -> None:
        flush_s = time.monotonic() + _FLUSH_PERIOD_S
        metadata_s = 0.0
        while True:
            with suppress(Empty):
                job = self._jobs.get(timeout=max(0.0, flush_s - time.monotonic()))
                if job is None:
                    return
                if job[2] is None:
                    metadata_s = 0.0
                self._write(*job)
            now_s = time.monotonic()
            if now_s >= flush_s:
                self._writer.flush()
                flush_s = now_s + _FLUSH_PERIOD_S
                if now_s >= metadata_s:
                    self._writer.write_metadata()
                    metadata_s = now_s + _METADATA_PERIOD_S

    def _write(self, topic: BagTopic, time_ns: int, payload: bytes | None) -> None:
        if payload is None:
            self._writer.add_topic(topic)
            return
        self._written[topic.name] += 1
        self._writer.write(topic, time_ns, payload)
        if self._is_closing:
            STOP_LIMIT.making_progress()
        with self._lock:
            self._queued_bytes -= len(payload) + _MESSAGE_BYTES

    def _fail(self, reason: str) -> None:
        with self._lock:
            self.failure = reason
        self._writer.abandon()
        kept = {it.name: n for it, n in self._writer.metadata.message_counts().items()}
        with suppress(Empty), self._lock:
            self._dropped += self._written - Counter(kept)
            self._written = Counter(kept)
            while True:
                job = self._jobs.get_nowait()
                if job is not None and job[2] is not None:
                    self._dropped[job[0].name] += 1
        self._on_failure(reason)

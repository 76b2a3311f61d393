"""Diagnostics of a receiver; a test says what its topic received, and what the headset told."""

from dataclasses import replace
from typing import Any

from ml2_receiver.session.report import Report, State, TopicReport
from ml2_receiver.session.statistics import TopicStatistics
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.diagnostics import Diagnostics, Row
from ml2_receiver.topics.judgement import read_judgements
from ml2_receiver.wire.frame import MAGIC, VERSION, Header
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import ChannelStatus, ClockStatus, StreamAnswer, StreamStatus

MS = 1_000_000
IMAGE = load_table().streams["world_left"].topics[0]
SENT_ALL = ChannelStatus(10, 10, {})
AT_30_HZ = {"world_left": StreamAnswer("applied", {"update_rate": 30})}


def receive(statistics: TopicStatistics, *sequences: int) -> None:
    """Messages are captured 100 ms apart, sent 1 ms later and received after 4 ms."""
    for sequence in sequences:
        capture_ns = sequence * 100 * MS
        times = (capture_ns, capture_ns + MS)
        header = Header(MAGIC, VERSION, Kind.DATA, 0, 1, sequence, 125_000, *times)
        statistics.record(header, capture_ns + 4 * MS, capture_ns + 4 * MS + MS // 2)


class Watch:
    """Diagnostics over time, and the statistics of the topic that it is about."""

    def __init__(self) -> None:
        self.statistics = TopicStatistics()
        self._diagnostics = Diagnostics("/prefix")

    def receive(self, *sequences: int) -> None:
        receive(self.statistics, *sequences)

    def topic_report(self, topic: Topic, device: ChannelStatus | None = None) -> TopicReport:
        return TopicReport(topic, self.statistics, device)

    def report(self, device: ChannelStatus | None = None, **changes: Any) -> Report:
        """A session with an image topic, of which the headset counts `device`."""
        clock = ClockStatus("synchronised", -5, 6, 7)
        topics = [self.topic_report(IMAGE, device)]
        return replace(Report(State.CONNECTED, "Zoë", "id", clock, 3, True, topics), **changes)

    def lowered(self, **streams: StreamStatus) -> Report:
        return self.report(SENT_ALL, answers=AT_30_HZ, streams=streams)

    def running(self, stream: str, *topics: TopicReport, **changes: Any) -> Report:
        """A session with these topics whose headset says that the stream runs."""
        states = {stream: StreamStatus("running")}
        return replace(self.report(topics=list(topics), streams=states), **changes)

    def running_role(self, stream: str, role: str, **changes: Any) -> Report:
        """A session with one topic of a stream that runs; all that was sent has arrived."""
        (topic,) = [it for it in load_table().streams[stream].topics if it.role == role]
        device = ChannelStatus(self.statistics.received, self.statistics.received, {})
        return self.running(stream, self.topic_report(topic, device), **changes)

    def rows(self, report: Report | None, now_s: float = 0) -> list[Row]:
        return list(self._diagnostics.rows(report, now_s))

    def named(self, name: str, report: Report) -> list[Row]:
        return [row for row in self.rows(report) if row.name == name]

    def topic(self, report: Report, now_s: float = 0) -> Row:
        """The row of the last topic."""
        return self.rows(report, now_s)[-1]

    def states(self, report: Report, now_s: float = 0) -> dict[str, str]:
        """The states of streams, by the values of the session's row."""
        session, *_ = self.rows(report, now_s)
        return {id: it.text for id, it in read_judgements(session.values).items()}

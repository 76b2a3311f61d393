"""Losses that a recording states, over sessions and headsets."""

from collections.abc import Sequence

from ml2_receiver.recording.losses import Losses
from ml2_receiver.session.report import Report, State, TopicReport
from ml2_receiver.session.statistics import TopicStatistics
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.messages import ChannelStatus

TOPIC = load_table().streams["battery"].topics[0]
NAME = "/magic_leap2/battery"


def statistics(produced: int, received: int) -> TopicStatistics:
    found = TopicStatistics()
    found.produced, found.received, found.gaps = produced, received, produced - received
    return found


def report(
    found: TopicStatistics, state: State = State.CONNECTED, device: ChannelStatus | None = None
) -> Report:
    topics = [TopicReport(TOPIC, found, device)]
    return Report(state, "headset", "id", None, 0, state is State.ENDED, topics)


def counted(before: Report | None, reports: Sequence[Report]) -> dict[str, int]:
    losses = Losses("/magic_leap2", before)
    for each in reports:
        losses.update(each)
    return losses.by_topic()


def test_what_was_lost_before_does_not_count() -> None:
    found = statistics(10, 7)
    before = report(found)
    losses = Losses("/magic_leap2", before)
    losses.update(before)
    assert losses.by_topic() == {}
    found.produced, found.gaps = 12, 5
    losses.update(before)
    losses.update(before)
    assert losses.by_topic() == {NAME: 2}


def test_losses_of_an_app_that_starts_again_are_added() -> None:
    first, second = report(statistics(10, 7)), report(statistics(5, 4))
    assert counted(None, [first, first, second, first]) == {NAME: 3 + 1 + 3}
    assert counted(first, [first, second]) == {NAME: 1}


def test_in_the_end_those_after_the_last_that_arrived_count() -> None:
    found = statistics(10, 7)
    device = ChannelStatus(produced=12, sent=12, dropped={})
    reports = [report(found), report(found, State.ENDED, device)]
    assert counted(None, reports) == {NAME: 5}

import pytest

from fake_sink import FakeSink
from ml2_receiver.configuration.table import load_table
from ml2_receiver.errors import PublishError
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.topics.sink import Applied

BATTERY = load_table().streams["battery"].topics[0]


def test_every_sink_is_told_everything() -> None:
    sinks = [FakeSink(), FakeSink()]
    all_of_them = FanOut(sinks)
    applied = Applied("headset", "session", {}, [])
    all_of_them.open(BATTERY)(bytearray(b"payload"))
    all_of_them.configured(applied)
    all_of_them.event("event")
    for sink in sinks:
        assert sink.payloads == {"battery": [b"payload"]}
        assert (sink.opened, sink.applied, sink.events) == ([BATTERY], [applied], ["event"])


def test_what_one_refuses_the_others_get_and_the_caller_learns_of_it() -> None:
    sinks = [FakeSink(), FakeSink()]
    sinks[0].refuses = {"battery"}
    with pytest.raises(PublishError):
        FanOut(sinks).open(BATTERY)(bytearray(b"payload"))
    assert sinks[1].payloads == {"battery": [b"payload"]}


def test_a_topic_that_one_cannot_make_the_others_do_and_the_user_learns_of_it() -> None:
    sinks = [FakeSink(), FakeSink()]
    sinks[0].unmakeable = {BATTERY.type}
    FanOut(sinks).open(BATTERY)(bytearray(b"payload"))
    assert sinks[1].payloads == {"battery": [b"payload"]}
    assert sinks[0].events == sinks[1].events == [f"there is no {BATTERY.type}"]


def test_a_topic_that_none_can_make_is_refused() -> None:
    sink = FakeSink()
    sink.unmakeable = {BATTERY.type}
    with pytest.raises(PublishError):
        FanOut([sink]).open(BATTERY)

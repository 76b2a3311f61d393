import pytest

from fake_sink import FakeSink
from ml2_receiver.errors import PublishError
from ml2_receiver.session.sink import Applied
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.fan_out import FanOut

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


def test_a_sink_that_comes_later_gets_what_is_open_and_what_is_latched() -> None:
    early, late = FakeSink(), FakeSink()
    all_of_them = FanOut([early])
    (static,) = (it for it in load_table().streams["tf"].topics if it.role == "tf_static")
    ended = load_table().streams["gaze"].topics[0]
    battery, latched = all_of_them.open(BATTERY), all_of_them.open(static)
    all_of_them.open(ended)
    applied = Applied("headset", "session", {}, [BATTERY, static])
    all_of_them.configured(applied)
    battery(bytearray(b"before"))
    latched(bytearray(b"mounting"))
    all_of_them.add(late)
    battery(bytearray(b"after"))
    assert set(late.opened) == {BATTERY, static}
    assert late.applied == [applied]
    assert late.payloads == {"battery": [b"after"], "/tf_static": [b"mounting"]}
    all_of_them.remove(late)
    battery(bytearray(b"too late"))
    all_of_them.event("too late")
    assert late.payloads["battery"] == [b"after"]
    assert late.events == []
    assert early.payloads["battery"] == [b"before", b"after", b"too late"]


def test_a_later_sink_that_cannot_make_a_topic_gets_the_others() -> None:
    early, late = FakeSink(), FakeSink()
    late.unmakeable = {BATTERY.type}
    all_of_them = FanOut([early])
    battery, gaze = map(all_of_them.open, (BATTERY, load_table().streams["gaze"].topics[0]))
    all_of_them.add(late)
    for publish in (battery, gaze):
        publish(bytearray(b"payload"))
    assert early.events == [f"there is no {BATTERY.type}"]
    assert late.payloads == {"gaze": [b"payload"]}

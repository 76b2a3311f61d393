"""Topics that the device names itself."""

from dataclasses import replace

import pytest

from ml2_receiver.session.actions import Open, Send
from ml2_receiver.session.session import Session
from ml2_receiver.session.sink import Applied
from ml2_receiver.session.streams import Request
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import ChannelEnd, Configured, Error, Start, StreamAnswer
from scene import APPLIED, REQUEST, TOPICS, Scene, channel, frame

RULES = load_table().custom_topics
WITH_CUSTOM: Request = {**REQUEST, "custom": {}}
ANSWERS = {**APPLIED, "custom": StreamAnswer("applied", {})}
FIRST_ID = 200
FLOAT = "std_msgs/msg/Float32"


def custom(name: str, type: str = FLOAT) -> Topic:
    topic = RULES.topic(f"custom/{name}", type)
    assert topic is not None
    return topic


TEMPERATURE = custom("temperature")


def answered(scene: Scene, *topics: Topic) -> int:
    """Up to the CONFIGURED that comes after CHANNEL for `topics`; returns its request."""
    scene.request(WITH_CUSTOM)
    request = scene.asked()[-1].request
    for number, topic in enumerate(topics, FIRST_ID):
        scene.announce(topic, number)
    scene.receive(scene.control, Kind.CONFIGURED, Configured(request, ANSWERS))
    return request


def started(*topics: Topic) -> Scene:
    scene = Scene()
    scene.start()
    answered(scene, *topics)
    return scene


def session(scene: Scene) -> Session:
    assert scene.host.session is not None
    return scene.host.session


def starts(scene: Scene) -> list[Start]:
    return [body for _, body in scene.sent(scene.control) if isinstance(body, Start)]


def test_it_is_published_like_a_topic_of_the_table() -> None:
    scene = started(TEMPERATURE)
    scene.receive_data("sensors", FIRST_ID)
    assert len(scene.sink.payloads["custom/temperature"]) == 1
    assert TEMPERATURE in scene.sink.applied[-1].topics
    rows = {row.topic: row.statistics for row in scene.report().topics}
    assert rows[TEMPERATURE].received == 1


def test_start_tells_how_many_channels_were_seen_before_it() -> None:
    scene = started(TEMPERATURE)
    before = len(scene.kinds(scene.control))
    scene.announce(custom("humidity"), FIRST_ID + 1)
    assert scene.kinds(scene.control)[before:] == [Kind.START]
    first, last = starts(scene)[-2:]
    assert last.request == first.request
    assert (first.channels, last.channels) == (len(TOPICS) + 1, len(TOPICS) + 2)


def test_one_that_comes_after_configured_is_routed_and_told_at_once() -> None:
    scene = started()
    scene.announce(TEMPERATURE, FIRST_ID)
    scene.receive_data("sensors", FIRST_ID)
    assert len(scene.sink.payloads["custom/temperature"]) == 1
    assert TEMPERATURE in scene.sink.applied[-1].topics


def test_it_is_opened_before_it_is_started() -> None:
    scene = started()
    scene.host.received(scene.control, frame(Kind.CHANNEL, channel(TEMPERATURE, FIRST_ID)), 0)
    scene.host.update(scene.desired, 0)
    opened, applied, started_ = scene.host.actions
    assert isinstance(opened, Open)
    assert isinstance(applied, Applied)
    assert isinstance(started_, Send)


def test_while_paused_one_that_comes_late_waits_for_its_start() -> None:
    scene = Scene(is_paused=True)
    scene.answer()
    answered(scene)
    scene.announce(TEMPERATURE, FIRST_ID)
    assert starts(scene) == []
    scene.desire(is_paused=False)
    scene.receive_data("sensors", FIRST_ID)


def test_a_type_that_is_not_there_is_told_to_device_and_user_and_the_session_goes_on() -> None:
    scene = Scene()
    scene.start()
    scene.sink.unmakeable = {"my_msgs/msg/Thing"}
    answered(scene, custom("thing", "my_msgs/msg/Thing"), TEMPERATURE)
    (error,) = [body for _, body in scene.sent(scene.control) if isinstance(body, Error)]
    assert (error.code, error.fatal, error.channel) == ("channel", False, FIRST_ID)
    assert any("my_msgs/msg/Thing" in event for event in scene.sink.events)
    scene.receive_data("sensors", FIRST_ID)
    scene.receive_data("sensors", FIRST_ID + 1)
    assert len(scene.sink.payloads["custom/temperature"]) == 1
    assert session(scene).instance.topics["custom/thing"].unpublished == 1


def test_a_type_that_is_not_there_is_not_told_to_a_device_that_has_gone() -> None:
    scene = started()
    scene.sink.unmakeable = {FLOAT}
    scene.host.received(scene.control, frame(Kind.CHANNEL, channel(TEMPERATURE, FIRST_ID)), 0)
    scene.host.closed(scene.control, None, 0)
    scene.perform()
    assert Kind.ERROR not in scene.kinds(scene.control)


@pytest.mark.parametrize(
    "type",
    ["std_msgs/srv/Trigger", "os/path", "std_msgs/msg/float32", "../msg/A", f"a/msg/A{'b' * 122}"],
)
def test_a_type_that_cannot_be_one_ends_the_session(type: str) -> None:
    scene = started()
    scene.receive(scene.control, Kind.CHANNEL, replace(channel(TEMPERATURE, 200), type=type))
    assert scene.error(scene.control) == "channel"


def test_none_may_come_unless_they_were_asked_for() -> None:
    scene = Scene()
    scene.start()
    scene.announce(TEMPERATURE, FIRST_ID)
    assert scene.error(scene.control) == "channel"


def test_one_that_crosses_the_configure_that_forbids_it_may_be_ended() -> None:
    scene = started()
    scene.request(REQUEST)
    scene.announce(TEMPERATURE, FIRST_ID)
    scene.receive(scene.control, Kind.CHANNEL_END, ChannelEnd(FIRST_ID))
    request = scene.asked()[-1].request
    scene.receive(scene.control, Kind.CONFIGURED, Configured(request, APPLIED))
    assert scene.is_connected()
    scene.announce(TEMPERATURE, FIRST_ID)
    assert scene.error(scene.control) == "channel"


def test_a_name_keeps_its_type() -> None:
    scene = started(TEMPERATURE)
    scene.receive(scene.control, Kind.CHANNEL_END, ChannelEnd(FIRST_ID))
    scene.announce(custom("temperature", "std_msgs/msg/Float64"), FIRST_ID)
    assert scene.error(scene.control) == "channel"


def test_the_names_of_an_app_are_bounded_even_if_they_end() -> None:
    scene = started()
    for number in range(RULES.max_topics):
        scene.announce(custom(f"topic{number}"), FIRST_ID)
        scene.receive(scene.control, Kind.CHANNEL_END, ChannelEnd(FIRST_ID))
    scene.announce(custom("topic0"), FIRST_ID)
    assert scene.is_connected()
    scene.announce(custom("last_straw"), FIRST_ID + 1)
    assert scene.error(scene.control) == "channel"


def test_the_next_session_of_an_app_reports_the_topics_of_the_last() -> None:
    scene = started(TEMPERATURE)
    scene.receive_data("sensors", FIRST_ID)
    scene.greet()
    for lane in list(scene.lanes.values()):
        scene.end(lane)
    assert scene.report().topics[-1].topic == TEMPERATURE

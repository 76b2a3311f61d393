"""Topics that the device names itself."""

import base64
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import pytest

from fake_sink import FakeGraph
from ml2_receiver.configuration.app_rules import AppRules, NameRules
from ml2_receiver.errors import ProtocolError
from ml2_receiver.session.actions import Open, Send
from ml2_receiver.session.session import Session
from ml2_receiver.session.sink import Applied
from ml2_receiver.session.streams import Request
from ml2_receiver.session.will import Will
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import (
    Channel,
    ChannelEnd,
    Configured,
    Error,
    Start,
    StreamAnswer,
    WillBody,
)
from scene import APPLIED, REQUEST, TOPICS, Scene, channel, data, frame
from waiting import LIMIT_S, await_true

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
COMMAND = RULES.topic("/cmd_vel", FLOAT) or TEMPERATURE
LATCHED = RULES.topic("custom/mode", FLOAT, "latched") or TEMPERATURE
LAST_WORD = b"\0\1\0\0last"
SAID = bytes(data(0).body)


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


def with_rules(*publish: str, remapped: Mapping[str, str] = MappingProxyType({})) -> Scene:
    """A Scene up to START, with openings, whose user lets apps publish names."""
    graph = FakeGraph()
    graph.remapped.update(remapped)
    scene = Scene(app=AppRules(publish=NameRules(publish)), graph=graph)
    scene.start()
    answered(scene)
    return scene


def will(topic: Topic, silent_ms: int = 5000) -> Channel:
    last = base64.b64encode(LAST_WORD).decode()
    return replace(channel(topic, FIRST_ID), will=WillBody(last, silent_ms))


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


def refusals(scene: Scene) -> list[str]:
    errors = [body for _, body in scene.sent(scene.control) if isinstance(body, Error)]
    assert {(it.code, it.fatal, it.channel) for it in errors} <= {("channel", False, FIRST_ID)}
    return [it.message for it in errors]


def test_an_absolute_name_is_published_where_the_rules_have_it() -> None:
    scene = with_rules("/cmd_vel")
    scene.announce(COMMAND, FIRST_ID)
    scene.receive_data("sensors", FIRST_ID)
    assert len(scene.sink.payloads["/cmd_vel"]) == 1
    assert refusals(scene) == []


def test_other_absolute_names_are_refused_with_the_reason_and_their_data_is_counted() -> None:
    scene = with_rules("/cmd_vel/*")
    scene.announce(COMMAND, FIRST_ID)
    scene.receive_data("sensors", FIRST_ID)
    assert refusals(scene) == ["no rule in app.publish has /cmd_vel"]
    assert "/cmd_vel" not in scene.sink.payloads
    assert session(scene).instance.topics["/cmd_vel"].unpublished == 1
    assert scene.is_connected()


def test_names_are_held_to_the_rules_after_remappings() -> None:
    scene = with_rules("/cmd_vel", remapped={"/cmd_vel": "/robot/cmd_vel"})
    scene.announce(COMMAND, FIRST_ID)
    assert refusals(scene) == ["no rule in app.publish has /robot/cmd_vel"]


def test_a_rule_that_is_taken_away_ends_the_topic_with_its_will() -> None:
    scene = with_rules("/cmd_vel")
    scene.receive(scene.control, Kind.CHANNEL, will(COMMAND))
    scene.receive_data("sensors", FIRST_ID)
    scene.app = AppRules()
    scene.pass_time(0.1)
    assert refusals(scene) == ["no rule in app.publish has /cmd_vel"]
    with_data_after(scene)
    assert scene.sink.payloads["/cmd_vel"] == [SAID, LAST_WORD]
    scene.pass_time(0.1)
    assert len(refusals(scene)) == 1


def with_data_after(scene: Scene) -> None:
    scene.receive_data("sensors", FIRST_ID, 1)
    (name,) = (it for it in session(scene).instance.topics if it.startswith(("/cmd", "custom/")))
    assert session(scene).instance.topics[name].unpublished == 1


def test_a_latched_topic_is_opened_as_one() -> None:
    scene = with_rules()
    scene.announce(LATCHED, FIRST_ID)
    scene.receive_data("sensors", FIRST_ID)
    assert LATCHED in scene.sink.applied[-1].topics
    assert LATCHED.qos == "latched"


@pytest.mark.parametrize(
    "announced", [channel(COMMAND, FIRST_ID), channel(LATCHED, FIRST_ID), will(TEMPERATURE)]
)
def test_a_session_without_openings_has_plain_topics_alone(announced: Channel) -> None:
    scene = started()
    scene.receive(scene.control, Kind.CHANNEL, announced)
    assert scene.error(scene.control) == "channel"


@pytest.mark.parametrize(
    "name", ["/tf", "/a//b", "/a/", "/", "/9", "/a__b", "/_a", f"/{'a' * 255}"]
)
def test_names_that_are_the_receivers_or_none_end_the_session(name: str) -> None:
    scene = with_rules("/**")
    scene.receive(scene.control, Kind.CHANNEL, replace(channel(COMMAND, FIRST_ID), topic=name))
    assert scene.error(scene.control) == "channel"


def test_a_will_is_published_once_in_each_silence_and_not_before_the_first_message() -> None:
    scene = with_rules()
    scene.receive(scene.control, Kind.CHANNEL, will(TEMPERATURE, silent_ms=50))
    payloads = scene.sink.payloads["custom/temperature"]
    for sequence in range(2):
        scene.receive_data("sensors", FIRST_ID, sequence)
        await_true(lambda: payloads == [SAID, LAST_WORD] * (sequence + 1))  # noqa: B023
    scene.lanes["sensors"].end_wills()
    assert payloads == [SAID, LAST_WORD] * 2
    scene.pass_time(0.1)
    assert sum("its will is published" in it for it in scene.sink.events) == 1


def test_messages_in_time_put_a_will_off() -> None:
    heard: list[bytes] = []
    last = Will("topic", LAST_WORD, silent_s=LIMIT_S)
    for _ in range(3):
        last.publish(lambda it: heard.append(bytes(it)), bytearray(SAID))
    assert heard == [SAID] * 3
    last.close()
    last.close()
    assert heard == [SAID] * 3 + [LAST_WORD]


@pytest.mark.parametrize("is_by_device", [True, False])
def test_the_end_of_a_channel_or_its_lane_publishes_the_will_as_its_last_word(
    *, is_by_device: bool
) -> None:
    scene = with_rules()
    scene.receive(scene.control, Kind.CHANNEL, will(TEMPERATURE))
    scene.receive_data("sensors", FIRST_ID)
    if is_by_device:
        scene.receive(scene.control, Kind.CHANNEL_END, ChannelEnd(FIRST_ID))
        with_data_after(scene)
    else:
        scene.end(scene.control)
        scene.lanes["sensors"].end_wills()
        scene.end(scene.lanes["sensors"])
        assert any("its will is published" in it for it in scene.sink.events)
    assert scene.sink.payloads["custom/temperature"] == [SAID, LAST_WORD]


@pytest.mark.parametrize(
    ("payload", "silent_ms"),
    [("AAEAAA==", 49), ("AAEAAA==", 5001), ("AAEAAA", 50), ("AAAAAA==", 50)],
)
def test_a_will_that_is_none_is_malformed(payload: str, silent_ms: int) -> None:
    body = channel(TEMPERATURE, FIRST_ID).to_bytes()[:-1]
    wrong = body + f',"will":{{"payload":"{payload}","silent_ms":{silent_ms}}}}}'.encode()
    with pytest.raises(ProtocolError, match=r"payload: |silent_ms: "):
        Channel.parse(wrong)


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

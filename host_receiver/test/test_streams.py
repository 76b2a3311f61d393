import pytest

from ml2_receiver.errors import ErrorCode, ProtocolError
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import ChannelEnd, Configured, Start, StreamAnswer
from scene import APPLIED, IMAGE, REQUEST, TOPICS, Scene, data, started

REFUSED = StreamAnswer("refused", None, "covered")


def configuring() -> tuple[Scene, int]:
    scene = Scene()
    return scene, scene.configure()


def test_channels_open_their_topics_before_start() -> None:
    scene = Scene()
    scene.answer()
    assert scene.sink.opened == TOPICS
    (applied,) = scene.sink.applied
    assert (applied.headset, applied.session) == ("a name", scene.welcome.session)
    assert applied.streams == APPLIED
    assert applied.topics == TOPICS
    assert scene.kinds(scene.control)[-1] == Kind.START


def test_payloads_go_to_their_topics_after_start() -> None:
    scene = started()
    for number in range(1, len(TOPICS) + 1):
        scene.receive_data(TOPICS[number - 1].lane.name, number)
    assert set(scene.sink.payloads) == {topic.name for topic in TOPICS}


@pytest.mark.parametrize(("is_wanted", "error"), [(False, "channel"), (True, None)])
def test_a_topic_with_a_condition_needs_its_key(is_wanted: bool, error: str | None) -> None:
    depth = load_table().streams["depth"]
    confidence = next(topic for topic in depth.topics if topic.role == "confidence")
    scene = Scene()
    scene.request({"depth": {"confidence": is_wanted}})
    scene.configure()
    scene.announce(confidence, 1)
    assert scene.error(scene.control) == error


def test_what_was_on_its_way_when_a_channel_ended_still_arrives() -> None:
    scene = started()
    scene.receive(scene.control, Kind.CHANNEL_END, ChannelEnd(1))
    scene.receive_data("world_left", 1)
    assert len(scene.sink.payloads[IMAGE.name]) == 1


@pytest.mark.parametrize("request_change", [-1, 1])
def test_configured_of_another_request_is_unexpected(request_change: int) -> None:
    scene, request = configuring()
    scene.receive(scene.control, Kind.CONFIGURED, Configured(request + request_change, APPLIED))
    assert scene.error(scene.control) == "unexpected"


def test_a_refused_stream_cannot_have_channels() -> None:
    scene, request = configuring()
    scene.announce(IMAGE, 1)
    scene.receive(
        scene.control, Kind.CONFIGURED, Configured(request, APPLIED | {"world_left": REFUSED})
    )
    assert scene.error(scene.control) == "channel"


def test_why_a_stream_does_not_run_is_said() -> None:
    scene, request = configuring()
    streams = APPLIED | {
        "world_left": REFUSED,
        "battery": StreamAnswer("adjusted", {}, "slower"),
    }
    scene.receive(scene.control, Kind.CONFIGURED, Configured(request, streams))
    assert scene.sink.events[-3:] == [
        "'a name': world_left refused: 'covered'",
        "'a name': battery adjusted: 'slower'",
        "'a name': streams: battery, tf",
    ]


def test_a_paused_receiver_starts_on_request() -> None:
    scene = Scene(is_paused=True)
    request = scene.answer()
    scene.receive(scene.control, Kind.PONG)
    assert Kind.START not in scene.kinds(scene.control)
    scene.desire(is_paused=False)
    scene.desire(is_paused=False)
    starts = [body for kind, body in scene.sent(scene.control) if kind == Kind.START]
    assert starts == [Start(request)]


def refusal(scene: Scene, number: int) -> ErrorCode:
    lane = scene.lanes["world_left"]
    assert number not in lane.routes
    error = scene.host.refusal(lane, number)
    scene.fail(lane, error)
    assert scene.error(lane) == error.code
    assert not scene.is_connected()
    return error.code


def test_data_before_start_is_unexpected() -> None:
    scene = Scene(is_paused=True)
    scene.answer()
    assert refusal(scene, 1) == "unexpected"


@pytest.mark.parametrize("payload", [b"", b"\0\1\0", b"\0\0\0\0", b"\1\0\0\0more"])
def test_a_payload_that_is_not_plain_cdr_is_malformed_and_not_published(payload: bytes) -> None:
    scene = started()
    with pytest.raises(ProtocolError) as raised:
        scene.lanes["world_left"].routes[1].receive(data(1)._replace(body=bytearray(payload)), 0, 0)
    assert raised.value.code == "malformed"
    assert not scene.sink.payloads


def test_a_repeated_number_is_malformed_and_not_published() -> None:
    scene = started()
    scene.receive_data("world_left", 1, sequence=5)
    with pytest.raises(ProtocolError) as raised:
        scene.receive_data("world_left", 1, sequence=5)
    assert raised.value.code == "malformed"
    assert len(scene.sink.payloads[IMAGE.name]) == 1


def test_what_ros_does_not_take_is_counted() -> None:
    scene = Scene()
    scene.sink.refuses.add(IMAGE.name)
    scene.start()
    scene.receive_data("world_left", 1)
    (statistics,) = [it.statistics for it in scene.report().topics if it.topic is IMAGE]
    assert (statistics.received, statistics.unpublished) == (1, 1)


def test_a_second_configuration_ends_and_begins_channels() -> None:
    scene = Scene()
    request = scene.answer()
    session = scene.host.session
    assert session is not None
    wider = {stream: values for stream, values in REQUEST.items() if stream != "battery"}
    wider["head_pose"] = {}
    scene.request(wider)
    battery = next(topic for topic in TOPICS if topic.stream == "battery")
    scene.receive(scene.control, Kind.CHANNEL_END, ChannelEnd(TOPICS.index(battery) + 1))
    (pose,) = load_table().streams["head_pose"].topics
    scene.announce(pose, 50)
    assert 50 not in scene.lanes["sensors"].routes
    assert session.streams.data_error(50).code == "unexpected"
    answers = {stream: StreamAnswer("applied", values) for stream, values in wider.items()}
    scene.receive(scene.control, Kind.CONFIGURED, Configured(request + 1, answers))
    assert scene.sent(scene.control)[-1] == (Kind.START, Start(request + 1))
    assert scene.sink.applied[-1].topics == [t for t in TOPICS if t is not battery] + [pose]
    scene.receive_data("sensors", 50)

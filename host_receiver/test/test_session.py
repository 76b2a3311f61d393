import json
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ml2_receiver.errors import ErrorCode, ProtocolError
from ml2_receiver.session.actions import Ending
from ml2_receiver.session.connection import Connection
from ml2_receiver.session.report import State
from ml2_receiver.session.settings import Limits
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import Bye, ChannelStatus, ClockStatus, Error, Event, Status
from scene import IMAGE, Scene, channel, hello, started

STATUS = Status(
    True,
    2.5,
    {IMAGE.name: ChannelStatus(5, 4, {"queue_full": 1}), "unheard/of": ChannelStatus(1, 1, {})},
    ClockStatus("holdover", -3, 2, 1),
)


@pytest.fixture
def scene() -> Scene:
    return started()


def end_all(scene: Scene, but: Connection | None = None) -> None:
    for connection in (*scene.lanes.values(), scene.control):
        if connection is not but:
            scene.end(connection)


def test_a_receiver_that_meets_an_instance_late_reports_only_its_own_losses() -> None:
    scene = Scene()
    before = ChannelStatus(produced=12, sent=9, dropped={"queue_full": 3})
    greeting = replace(hello(), channels={IMAGE.name: before})
    scene.begin(greeting)
    assert scene.welcome.received is None
    scene.join("time")
    scene.join("sensors")
    scene.announce(IMAGE, 1)
    later = ChannelStatus(produced=15, sent=11, dropped={"queue_full": 4})
    status = replace(STATUS, final=False, channels={IMAGE.name: later})
    scene.receive(scene.control, Kind.STATUS, status)
    [topic] = scene.report().topics
    assert topic.device == ChannelStatus(3, 2, {"queue_full": 1})
    end_all(scene)  # the link broke
    scene.begin(greeting)
    assert scene.welcome.received == {IMAGE.name: 9}


def test_ping_is_answered(scene: Scene) -> None:
    scene.receive(scene.control, Kind.PING)
    assert scene.kinds(scene.control)[-1] == Kind.PONG


def test_a_receiver_that_has_nothing_to_say_says_ping(scene: Scene) -> None:
    ping_s = Limits().ping_s
    scene.pass_time(0.9 * ping_s)
    assert scene.kinds(scene.control)[-1] == Kind.START
    scene.pass_time(0.2 * ping_s)
    assert scene.kinds(scene.control)[-1] == Kind.PING
    scene.pass_time(0.9 * ping_s)
    assert scene.kinds(scene.control).count(Kind.PING) == 1


@pytest.mark.parametrize("kind", [Kind.PONG, 200])
def test_any_frame_on_control_keeps_a_session(scene: Scene, kind: int) -> None:
    for _ in range(10):
        scene.pass_time(2.9)
        scene.receive(scene.control, kind)
    assert scene.is_connected()


def test_a_receiver_that_stood_still_first_hears_what_came_meanwhile(scene: Scene) -> None:
    for _ in range(3):
        scene.pass_time(1.5)
        scene.stand_still(60.0)
        scene.receive(scene.control, Kind.PING)
    assert scene.is_connected()
    scene.stand_still(60.0)
    scene.pass_time(2.1)
    assert scene.error(scene.control) == "timeout"


def test_what_came_before_the_first_tick_after_a_standstill_does_not_count_twice(
    scene: Scene,
) -> None:
    scene.pass_time(1.0)
    scene.now_s += 60.0
    scene.receive(scene.control, Kind.PING)
    scene.stand_still(0.1)
    assert scene.is_connected()
    scene.pass_time(Limits().dead_s + 0.1)
    assert scene.error(scene.control) == "timeout"


def test_silence_on_control_ends_a_session(scene: Scene) -> None:
    scene.pass_time(2.9)
    scene.receive(scene.lanes["sensors"], 200)
    scene.pass_time(0.2)
    assert scene.error(scene.control) == "timeout"
    assert {scene.ending(lane) for lane in scene.lanes.values()} == {Ending.DRAIN}


@pytest.mark.parametrize("event", ["tracking_lost", "of a later version"])
@pytest.mark.parametrize(("age_s", "age"), [(90.4, ", 90 s ago"), (0.9, ""), (None, "")])
def test_an_event_of_the_device_is_told_with_its_age(
    scene: Scene, event: str, age_s: float | None, age: str
) -> None:
    scene.receive(scene.control, Kind.EVENT, Event(event, "tracking\nis lost", age_s))
    assert scene.sink.events[-1] == rf"'a name': 'tracking\nis lost'{age}"
    assert scene.is_connected()


def test_after_bye_every_lane_is_read_to_its_end(scene: Scene) -> None:
    scene.end(scene.lanes["time"])
    scene.end(scene.lanes["sensors"])
    scene.receive(scene.control, Kind.STATUS, STATUS)
    scene.receive(scene.control, Kind.BYE, Bye("done"))
    scene.end(scene.control)
    assert scene.is_connected()
    scene.receive_data("world_left", 1)
    scene.end(scene.lanes["world_left"])
    (report,) = scene.sink.reports
    assert report.state is State.ENDED
    assert report.is_final


def test_after_bye_a_reset_of_control_is_no_loss(scene: Scene) -> None:
    scene.receive(scene.control, Kind.BYE, Bye("done"))
    scene.end(scene.control, "Connection reset by peer")
    scene.receive_data("world_left", 1)
    assert scene.is_connected()
    for lane in scene.lanes.values():
        scene.end(lane)
    assert [report.state for report in scene.sink.reports] == [State.ENDED]


def test_after_bye_a_lane_that_does_not_end_is_waited_for_3_seconds(scene: Scene) -> None:
    scene.receive(scene.control, Kind.BYE, Bye("done"))
    scene.pass_time(2.9)
    assert scene.is_connected()
    scene.pass_time(0.2)
    assert not scene.is_connected()
    assert scene.sink.reports == []
    end_all(scene)
    assert [report.state for report in scene.sink.reports] == [State.ENDED]


def test_lanes_may_end_shortly_before_bye(scene: Scene) -> None:
    scene.end(scene.lanes["world_left"])
    scene.end(scene.lanes["sensors"])
    scene.pass_time(2.9)
    assert scene.is_connected()
    scene.receive(scene.control, Kind.BYE, Bye("done"))
    end_all(scene, but=scene.lanes["sensors"])
    assert [report.state for report in scene.sink.reports] == [State.ENDED]


def test_a_lane_that_ends_without_bye_is_a_loss_after_3_seconds(scene: Scene) -> None:
    scene.end(scene.lanes["time"])
    scene.pass_time(2.9)
    scene.receive(scene.control, Kind.PONG)
    scene.pass_time(0.2)
    assert scene.kinds(scene.control)[-1] == Kind.BYE
    end_all(scene, but=scene.lanes["time"])
    assert [report.state for report in scene.sink.reports] == [State.LOST]


def test_a_lane_that_ends_inside_a_frame_is_a_loss_at_once(scene: Scene) -> None:
    scene.end(scene.lanes["world_left"], "ended inside a frame")
    assert not scene.is_connected()
    assert "'world_left': ended inside a frame" in scene.sink.events[-1]


def test_control_that_ends_without_bye_is_a_loss_at_once(scene: Scene) -> None:
    scene.end(scene.control)
    assert not scene.is_connected()
    assert {scene.ending(lane) for lane in scene.lanes.values()} == {Ending.DRAIN}


def test_what_has_arrived_when_a_session_is_lost_is_still_received(scene: Scene) -> None:
    scene.end(scene.control)
    scene.receive_data("world_left", 1)
    end_all(scene, but=scene.control)
    (report,) = scene.sink.reports
    assert {row.topic.name: row.statistics.received for row in report.topics}[IMAGE.name] == 1


def test_a_fault_on_a_lane_is_told_there_and_ends_the_session(scene: Scene) -> None:
    lane = scene.lanes["world_left"]
    scene.fail(lane, ProtocolError(ErrorCode.MALFORMED, "x" * 100_000))
    assert scene.error(lane) == "malformed"
    assert not scene.is_connected()
    body = scene.sent(lane)[-1][1]
    assert body is not None
    assert len(body.to_bytes()) < Kind.ERROR.max_length


def test_only_the_first_fault_of_a_connection_is_told(scene: Scene) -> None:
    for _ in range(2):
        scene.fail(scene.control, ProtocolError(ErrorCode.MALFORMED, ""))
    scene.receive(scene.control, Kind.BYE, b"nonsense")
    assert scene.kinds(scene.control).count(Kind.ERROR) == 1


def test_an_error_that_is_not_fatal_is_logged(scene: Scene) -> None:
    scene.receive(scene.control, Kind.ERROR, Error("source", "depth is covered", fatal=False))
    assert "'source': 'depth is covered'" in scene.sink.events[-1]
    assert scene.is_connected()


def test_a_device_cannot_flood_the_log(scene: Scene) -> None:
    before = len(scene.sink.events)
    for _ in range(1000):
        scene.receive(scene.control, Kind.ERROR, Error("source", "", fatal=False))
    assert len(scene.sink.events) - before <= 100


@pytest.mark.parametrize("body", [Error("malformed", "", fatal=True), b"nonsense"])
def test_an_error_is_never_answered(scene: Scene, body: Error | bytes) -> None:
    sent = scene.sent(scene.lanes["time"])
    scene.receive(scene.lanes["time"], Kind.ERROR, body)
    assert not scene.is_connected()
    assert scene.sent(scene.lanes["time"]) == sent
    assert scene.ending(scene.lanes["time"]) is not None


def test_the_last_status_is_reported(scene: Scene) -> None:
    scene.receive(scene.control, Kind.STATUS, STATUS)
    report = scene.report()
    assert (report.headset, report.device_id, report.is_final) == ("a name", "a", True)
    assert report.clock == STATUS.clock
    by_topic = {row.topic.name: row for row in report.topics}
    assert by_topic[IMAGE.name].device == STATUS.channels[IMAGE.name]
    assert by_topic["/tf"].device is None
    assert "unheard/of" not in by_topic


def test_a_device_that_said_goodbye_and_is_back_at_once_did_not_lose_its_session(
    scene: Scene,
) -> None:
    scene.receive(scene.control, Kind.BYE, Bye("done"))
    old_control = scene.control
    scene.control = scene.greet()
    for connection in (old_control, *scene.lanes.values()):
        scene.end(connection)
    assert [report.state for report in scene.sink.reports] == [State.ENDED]
    scene.take_welcome()


BODIES = [hello(), channel(IMAGE, 1), Bye("x"), STATUS, Error("x", "y", fatal=False)]


@given(
    st.lists(
        st.tuples(
            st.integers(0, 3),
            st.sampled_from([*(int(kind) for kind in Kind if kind != Kind.DATA), 200]),
            st.one_of(
                st.sampled_from([body.to_bytes() for body in BODIES]),
                st.binary(max_size=20),
                st.recursive(
                    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
                    lambda inner: st.lists(inner) | st.dictionaries(st.text(max_size=5), inner),
                ).map(lambda value: json.dumps(value).encode()),
            ),
            st.floats(0, 3),
        ),
        max_size=15,
    )
)
def test_no_frames_make_the_host_stumble(frames: list[tuple[int, int, bytes, float]]) -> None:
    scene = started()
    connections = [scene.control, scene.lanes["time"], scene.lanes["sensors"], scene.connect()]
    for place, kind, body, seconds in frames:
        scene.receive(connections[place], kind, body)
        scene.pass_time(seconds)
    for connection in connections:
        scene.end(connection)
    scene.end(scene.lanes["world_left"])
    scene.begin(hello("b"))

"""States of streams, from STATUS of the headset to the receiver's rows."""

from dataclasses import replace

from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import ClockStatus, Status, StreamAnswer, StreamStatus
from scene import REQUEST, Scene, started

CLOCK = ClockStatus("holdover", -3, 2, 1)
CAMERA = "android.permission.CAMERA"
WAITING = StreamStatus("waiting", "taken away", CAMERA)


def tell(scene: Scene, **streams: StreamStatus) -> None:
    scene.receive(scene.control, Kind.STATUS, Status(False, 2.5, {}, CLOCK, streams=streams))


def test_a_stream_that_stops_is_told_once_and_everywhere() -> None:
    scene = started()
    for _ in range(3):
        tell(scene, world_left=WAITING, battery=StreamStatus("running"))
    text = "world_left: waiting: taken away; android.permission.CAMERA is missing"
    assert len([event for event in scene.sink.events if text in event]) == 1
    assert scene.sink.applied[-1].states["world_left"] == WAITING
    assert scene.report().streams["world_left"] == WAITING
    assert scene.report().streams["battery"] == StreamStatus("running")
    tell(scene, world_left=StreamStatus("running"))
    assert scene.sink.events[-1].endswith("world_left: running again")
    assert scene.sink.applied[-1].states["world_left"] == StreamStatus("running")


def test_what_would_be_accepted_now_is_asked_for_again_once() -> None:
    scene = started()
    refused = {"world_left": StreamAnswer("refused", None, "no permission")}
    other = {**REQUEST, "world_left": {**REQUEST["world_left"], "update_rate": 5}}
    scene.request(other)
    scene.comply(refused)
    asked = len(scene.asked())
    known = StreamStatus("refused", "no permission", CAMERA)
    available = replace(known, state="available")
    tell(scene, world_left=known)
    assert len(scene.asked()) == asked
    for _ in range(3):
        tell(scene, world_left=available)
    assert [it.streams for it in scene.asked()[asked:]] == [other]
    scene.comply(refused)
    tell(scene, world_left=available)
    assert len(scene.asked()) == asked + 1, "nothing has changed"
    tell(scene, world_left=known)
    tell(scene, world_left=available)
    scene.comply()
    tell(scene, world_left=StreamStatus("running"))
    assert len(scene.asked()) == asked + 2
    assert scene.sink.applied[-1].streams["world_left"].result == "applied"
    assert scene.kinds(scene.control)[-1] == Kind.START


def test_a_device_that_says_nothing_of_its_streams_runs_what_it_accepted() -> None:
    scene = started()
    scene.receive(scene.control, Kind.STATUS, Status(False, 2.5, {}, CLOCK))
    states = {it.state for it in scene.report().streams.values()}
    assert states == {"running"}


def test_streams_that_stand_alike_are_told_in_one_line() -> None:
    scene = started()
    waiting = StreamStatus("waiting", "drawing the pictures")
    tell(scene, world_left=waiting, battery=waiting)
    tell(scene, world_left=StreamStatus("running"), battery=StreamStatus("running"))
    texts = [text for text in scene.sink.events if "world_left" in text and "battery" in text]
    assert texts[-2].endswith("world_left, battery: waiting: drawing the pictures")
    assert texts[-1].endswith("world_left, battery: running again")


def test_a_lowered_value_is_no_other_state_but_is_in_the_configuration() -> None:
    scene = started()
    events, lowered = len(scene.sink.events), StreamStatus("running", quality=40, rate_hz=15)
    for status in (StreamStatus("running", quality=60), lowered, lowered, StreamStatus("running")):
        tell(scene, world_left=status)
        assert scene.sink.applied[-1].states["world_left"] == status
        assert scene.report().streams["world_left"] == status
    assert len(scene.sink.applied) == 4, "once at the start, then for each change"
    assert scene.sink.events[events:] == []


def test_a_stream_that_stops_while_it_is_lowered_is_told_by_its_state() -> None:
    scene = started()
    tell(scene, world_left=StreamStatus("running", rate_hz=15))
    tell(scene, world_left=StreamStatus("waiting", "taken away", rate_hz=15))
    assert scene.sink.events[-1].endswith("world_left: waiting: taken away")
    tell(scene, world_left=StreamStatus("running", rate_hz=10))
    assert scene.sink.events[-1].endswith("world_left: running again")

"""Requests to a headset while it runs: other values, a pause, streams that are idle."""

from ml2_receiver.session.streams import Request
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import (
    ChannelEnd,
    Link,
    Start,
    StreamAnswer,
)
from scene import APPLIED, IMAGE, REQUEST, TOPICS, Scene, started

FASTER: Request = {**REQUEST, "world_left": {**REQUEST["world_left"], "update_rate": 5}}
SLOWER: Request = {**REQUEST, "world_left": {**REQUEST["world_left"], "update_rate": 1}}
AUTO, BOUNDED = Link(adapts=True), Link(adapts=True, most_mbit_per_s=100.0)
WITHOUT_CAMERA = {id: values for id, values in REQUEST.items() if id != "world_left"}


def streams(scene: Scene) -> list[Request]:
    return [asked.streams for asked in scene.asked()]


def test_another_request_is_negotiated_and_started() -> None:
    scene = started()
    scene.request(FASTER)
    assert streams(scene) == [REQUEST, FASTER]
    scene.comply()
    assert scene.sent(scene.control)[-1] == (Kind.START, Start(scene.asked()[-1].request))
    assert scene.sink.applied[-1].streams["world_left"].values == FASTER["world_left"]


def test_the_same_request_and_link_are_not_asked_for_again() -> None:
    scene = started(link=AUTO)
    scene.request(dict(REQUEST), Link(adapts=True))
    assert links(scene) == [(REQUEST, AUTO)]


def test_while_an_answer_is_outstanding_the_newest_request_waits_for_it() -> None:
    scene = started()
    scene.request(FASTER)
    scene.request(WITHOUT_CAMERA)
    scene.request(SLOWER)
    assert streams(scene) == [REQUEST, FASTER]
    scene.comply()
    assert streams(scene) == [REQUEST, FASTER, SLOWER]
    scene.comply()
    kinds = [kind for kind in scene.kinds(scene.control) if kind in (Kind.CONFIGURE, Kind.START)]
    assert kinds == [Kind.CONFIGURE, Kind.START, Kind.CONFIGURE, Kind.CONFIGURE, Kind.START]


def test_a_request_before_any_headset_is_what_the_first_is_asked_for() -> None:
    scene = Scene()
    scene.request(FASTER)
    scene.configure()
    assert streams(scene) == [FASTER]


def test_a_pause_stops_all_streams_and_keeps_topics_and_session() -> None:
    scene = started()
    scene.desire(is_paused=True)
    assert streams(scene) == [REQUEST, {}]
    scene.comply()
    assert scene.kinds(scene.control)[-1] == Kind.CONFIGURE
    assert scene.sink.applied[-1].topics == TOPICS
    assert scene.sink.applied[-1].streams == APPLIED
    assert scene.is_connected()
    scene.desire(is_paused=False)
    assert streams(scene) == [REQUEST, {}, REQUEST]
    scene.comply()
    assert scene.kinds(scene.control)[-1] == Kind.START


def test_a_pause_while_an_answer_is_outstanding_comes_after_it() -> None:
    scene = started()
    scene.request(FASTER)
    scene.desire(is_paused=True)
    scene.comply()
    assert streams(scene) == [REQUEST, FASTER, {}]
    scene.comply()
    scene.request(SLOWER)
    scene.comply()
    assert streams(scene) == [REQUEST, FASTER, {}, SLOWER]
    assert scene.kinds(scene.control).count(Kind.START) == 1
    scene.desire(is_paused=False)
    assert scene.sent(scene.control)[-1] == (Kind.START, Start(scene.asked()[-1].request))


def test_idle_streams_are_negotiated_and_then_left_out() -> None:
    scene = Scene()
    scene.desire(idle={"world_left"})
    scene.answer()
    assert streams(scene) == [REQUEST, WITHOUT_CAMERA]
    scene.comply()
    assert scene.sink.applied[-1].topics == TOPICS
    assert scene.sink.applied[-1].streams == APPLIED
    kinds = [kind for kind in scene.kinds(scene.control) if kind in (Kind.CONFIGURE, Kind.START)]
    assert kinds == [Kind.CONFIGURE, Kind.CONFIGURE, Kind.START]


def test_a_stream_that_is_needed_again_resumes() -> None:
    scene = Scene()
    scene.desire(idle={"world_left"})
    scene.answer()
    scene.comply()
    scene.desire(idle=set())
    assert streams(scene)[-1] == REQUEST
    scene.comply()
    assert scene.kinds(scene.control)[-1] == Kind.START
    scene.receive_data("world_left", 1)
    assert len(scene.sink.payloads[IMAGE.name]) == 1


def test_while_all_are_idle_nothing_is_started() -> None:
    scene = Scene()
    scene.desire(idle=set(REQUEST))
    scene.answer()
    scene.comply()
    assert streams(scene) == [REQUEST, {}]
    assert Kind.START not in scene.kinds(scene.control)


def test_reports_tell_which_streams_run() -> None:
    scene = started()
    scene.desire(idle={"world_left"})
    scene.comply()
    running = {row.topic.stream: row.is_running for row in scene.report().topics}
    assert running == {"world_left": False, "battery": True, "tf": True}


def test_a_topic_whose_channel_has_ended_does_not_run() -> None:
    scene = started()
    scene.receive(scene.control, Kind.CHANNEL_END, ChannelEnd(1))
    running = {row.topic.name: row.is_running for row in scene.report().topics}
    assert running == {topic.name: topic is not TOPICS[0] for topic in TOPICS}


def test_a_stream_that_is_refused_when_it_shall_resume_loses_its_topics() -> None:
    scene = started()
    scene.desire(idle={"world_left"})
    scene.comply()
    scene.desire(idle=set())
    refused = StreamAnswer("refused", None, "permission withdrawn")
    scene.comply({"world_left": refused})
    assert scene.sink.applied[-1].topics == [t for t in TOPICS if t.stream != "world_left"]
    assert scene.sink.applied[-1].streams["world_left"] == refused
    assert any("permission withdrawn" in event for event in scene.sink.events)


def test_a_withheld_stream_is_never_asked_for_and_the_reason_is_told_when_it_is_wanted() -> None:
    scene = started(excluded={"eye_nasal_left": "eye images are biometric"})
    assert "eye_nasal_left" not in scene.sink.applied[-1].streams
    scene.request({**REQUEST, "eye_nasal_left": {"stream": 0}})
    assert streams(scene)[-1] == REQUEST
    scene.comply()
    answer = scene.sink.applied[-1].streams["eye_nasal_left"]
    assert (answer.result, answer.reason) == ("refused", "eye images are biometric")
    scene.sink.await_event("eye_nasal_left refused: 'eye images are biometric'")
    assert scene.sent(scene.control)[-1][0] == Kind.START


def test_only_withheld_streams_leave_nothing_to_ask_for() -> None:
    scene = Scene(excluded=dict.fromkeys(REQUEST, "not here"))
    scene.configure()
    assert streams(scene) == [{}]


def links(scene: Scene) -> list[tuple[Request, Link | None]]:
    return [(asked.streams, asked.link) for asked in scene.asked()]


def test_a_headset_is_told_how_images_give_way_whenever_it_is_asked() -> None:
    scene = started(link=BOUNDED)
    scene.request(FASTER, BOUNDED)
    assert links(scene) == [(REQUEST, BOUNDED), (FASTER, BOUNDED)]


def test_another_link_alone_is_asked_for_with_the_same_streams() -> None:
    scene = started(link=AUTO)
    for link in (BOUNDED, None, AUTO):
        scene.request(REQUEST, link)
        assert links(scene)[-1] == (REQUEST, link)
        scene.comply()
        assert scene.sent(scene.control)[-1] == (Kind.START, Start(scene.asked()[-1].request))
    assert len(scene.asked()) == 4
    assert scene.sink.applied[-1].topics == TOPICS


def test_while_an_answer_is_outstanding_the_newest_link_waits_for_it() -> None:
    scene = started()
    scene.request(FASTER)
    scene.request(FASTER, BOUNDED)
    scene.request(FASTER, AUTO)
    assert links(scene)[1:] == [(FASTER, None)]
    scene.comply()
    assert links(scene)[1:] == [(FASTER, None), (FASTER, AUTO)]


def test_another_link_starts_neither_paused_nor_idle_streams() -> None:
    scene = started()
    scene.desire(is_paused=True)
    scene.comply()
    scene.request(REQUEST, AUTO)
    assert links(scene)[-1] == ({}, AUTO)
    scene.comply()
    scene.desire(idle={"world_left"}, is_paused=False)
    scene.comply()
    scene.request(REQUEST, BOUNDED)
    assert links(scene)[-1] == (WITHOUT_CAMERA, BOUNDED)


def test_another_link_in_a_pause_before_the_first_start_starts_nothing() -> None:
    scene = Scene(is_paused=True)
    scene.answer()
    scene.request(REQUEST, AUTO)
    scene.comply()
    assert links(scene) == [(REQUEST, None), (REQUEST, AUTO)]
    assert Kind.START not in scene.kinds(scene.control)

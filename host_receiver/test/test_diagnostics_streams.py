"""Tests how diagnostics judge streams: running, silent, paused, lowered for the link."""

from dataclasses import replace
from typing import Any

import pytest

from diagnostics_scene import AT_30_HZ, SENT_ALL, Watch, receive
from ml2_receiver.session.report import State, TopicReport
from ml2_receiver.session.statistics import TopicStatistics
from ml2_receiver.session.stream_state import Judgement
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.diagnostics import Level
from ml2_receiver.topics.judgement import read_judgements
from ml2_receiver.wire.messages import (
    ChannelStatus,
    StreamAnswer,
    StreamStatus,
)
from ml2_tools.doctor.devices import DeviceStream, read_device


@pytest.fixture
def watch() -> Watch:
    return Watch()


def test_a_topic_is_stale_when_the_device_produces_and_nothing_arrives(watch: Watch) -> None:
    levels = []
    for second in range(6):
        device = replace(SENT_ALL, produced=10 + second)
        if second < 2:
            watch.receive(second)
        levels.append(watch.topic(watch.report(device), second).level)
    assert levels == [Level.OK] * 4 + [Level.ERROR] * 2


@pytest.mark.parametrize("dropped", [0, 2])
def test_a_status_that_counts_late_makes_no_topic_stale(watch: Watch, dropped: int) -> None:
    watch.receive(*range(10))
    told = watch.running_role("battery", "battery")
    for second, missing in enumerate((5, 2, 0, 0, 0, 0)):
        produced = 10 + dropped - missing
        device = ChannelStatus(produced, produced - dropped, {"queue_full": dropped})
        late = replace(told, topics=[replace(told.topics[0], device=device)])
        assert watch.states(late, second) == {"battery": "running"}


def test_a_sensor_that_has_nothing_to_say_is_not_stale(watch: Watch) -> None:
    watch.receive(*range(10))
    for second in range(6):
        row = watch.topic(watch.running_role("battery", "battery"), second)
        assert row.level == Level.OK


CAMERA = "android.permission.CAMERA"


@pytest.mark.parametrize(
    ("status", "level"),
    [
        (StreamStatus("waiting", "taken away", CAMERA), Level.WARN),
        (StreamStatus("refused", "not granted", CAMERA), Level.WARN),
        (StreamStatus("failed", "broken"), Level.ERROR),
    ],
)
def test_a_stream_that_does_not_run_is_never_ok(
    watch: Watch, status: StreamStatus, level: Level
) -> None:
    told = watch.report(SENT_ALL, answers=AT_30_HZ, streams={"world_left": status})
    session, *_, topic = watch.rows(told)
    assert (session.level, topic.level) == (Level.WARN, level)
    assert session.values["state.world_left"] == f"{status.state}: {status.reason}"
    assert session.values.get("missing.world_left") == status.permission
    for row in (session, topic):
        assert f"{status.state}: {status.reason}" in row.message
        fix = f"{CAMERA} is missing: run `ml2-receiver headset grant world_left`"
        assert (fix in row.message) == (status.permission is not None)


def test_a_camera_that_has_sent_nothing_yet_is_waited_for(watch: Watch) -> None:
    told = watch.report(ChannelStatus(0, 0, {}), answers=AT_30_HZ)
    row = watch.topic(told)
    assert (row.level, row.message) == (Level.WARN, "waiting: no message has come yet")


def test_a_camera_that_sends_nothing_any_more_is_an_error(watch: Watch) -> None:
    watch.receive(*range(10))
    told = watch.report(SENT_ALL, answers=AT_30_HZ)
    levels = [watch.topic(told, second).level for second in range(5)]
    assert levels == [Level.OK] * 3 + [Level.ERROR] * 2
    assert "expected 30 Hz" in watch.topic(told, 5.0).message


LOWERED = StreamStatus("running", quality=60, rate_hz=15)


@pytest.mark.parametrize(
    ("streams", "level", "message", "values"),
    [
        ({}, Level.OK, "nothing is lowered", {}),
        ({"depth": StreamStatus("running")}, Level.OK, "nothing is lowered", {}),
        (
            {
                "world_left": LOWERED,
                "depth": StreamStatus("running", rate_hz=10),
                "battery": StreamStatus("running"),
                "world_right": LOWERED,
            },
            Level.WARN,
            "lowered for the link: world_left, world_right: quality 60, 15 Hz; depth: 10 Hz",
            {
                "world_left.quality": "60",
                "world_left.rate_hz": "15",
                "world_right.quality": "60",
                "world_right.rate_hz": "15",
                "depth.rate_hz": "10",
            },
        ),
    ],
)
def test_what_gives_way_to_the_link_has_a_row(
    watch: Watch,
    streams: dict[str, StreamStatus],
    level: Level,
    message: str,
    values: dict[str, str],
) -> None:
    (row,) = watch.named("adaptation", watch.lowered(**streams))
    assert (row.level, row.message, row.values) == (level, message, values)


@pytest.mark.parametrize("state", [State.ENDED, State.LOST])
def test_without_a_connection_nothing_gives_way(watch: Watch, state: State) -> None:
    told = replace(watch.lowered(world_left=LOWERED), state=state)
    assert watch.named("adaptation", told) == []


def test_a_lowered_rate_is_what_a_camera_is_judged_by(watch: Watch) -> None:
    slow = watch.lowered(world_left=StreamStatus("running", rate_hz=1))
    watch.receive(*range(10))
    row = watch.topic(slow)
    assert (row.level, row.values["expected_hz"]) == (Level.OK, "1")
    session, *_, topic = watch.rows(slow, 3.0)
    assert (session.level, topic.level) == (Level.WARN, Level.ERROR)
    assert topic.message == "silent: nothing has come for 3 s, expected 1 Hz"
    back = watch.lowered(world_left=StreamStatus("running", quality=60))
    assert watch.topic(back, 3.0).values["expected_hz"] == "30"


def test_a_stream_that_gives_way_is_well(watch: Watch) -> None:
    watch.receive(*range(10))
    session, *_, topic = watch.rows(watch.lowered(world_left=LOWERED))
    assert (session.level, topic.level) == (Level.OK, Level.OK)
    assert session.values["state.world_left"] == "running"


@pytest.mark.parametrize(
    ("stream", "role", "pause_s", "expected"),
    [
        ("head_pose", "pose", 2, "60 Hz"),
        ("gaze", "pose", 2, "60 Hz"),
        ("hand_left", "poses", 2, "60 Hz"),
        ("controller", "pose", 2, "60 Hz"),
        ("controller_joy", "joy", 2, "60 Hz"),
        ("tf", "tf", 2, "60 Hz"),
        ("gyro_left", "imu", 2, "a message every 2 s"),
        ("magnetometer_left", "magnetic_field", 2, "a message every 2 s"),
        ("pressure_headset", "pressure", 4, "a message every 4 s"),
        ("battery", "battery", 600, "a message every 600 s"),
    ],
)
def test_a_stream_is_silent_after_its_longest_pause(
    watch: Watch, stream: str, role: str, pause_s: int, expected: str
) -> None:
    watch.receive(*range(10))
    told = watch.running_role(stream, role)
    assert watch.topic(told).level == Level.OK
    assert watch.topic(told, pause_s).level == Level.OK
    session, *_, topic = watch.rows(told, pause_s + 1.0)
    words = f"nothing has come for {pause_s + 1} s, expected {expected}"
    assert (topic.level, topic.message) == (Level.ERROR, f"silent: {words}")
    assert session.level == Level.WARN
    assert read_judgements(session.values) == {stream: Judgement("silent", words)}
    device = read_device({"session": session.values}, load_table())
    assert device is not None
    assert DeviceStream(stream, "silent", words) in device.streams
    watch.receive(*range(10, 20))
    session, *_, topic = watch.rows(watch.running_role(stream, role), pause_s + 2.0)
    assert (session.level, topic.level) == (Level.OK, Level.OK)


def test_a_stream_that_never_delivers_is_not_waited_for_for_ever(watch: Watch) -> None:
    told = watch.running_role("gyro_left", "imu")
    rows = [watch.topic(told, second) for second in range(10)]
    assert {row.message for row in rows[:9]} == {"waiting: no message has come yet"}
    assert rows[9].level == Level.ERROR
    assert rows[9].message.startswith("silent: nothing has come for 9 s")


def test_a_latched_topic_may_be_silent(watch: Watch) -> None:
    watch.receive(0)
    told = watch.running_role("tf", "tf_static")
    assert {watch.topic(told, it).level for it in range(100)} == {Level.OK}


def test_a_topic_that_is_not_to_run_is_paused_and_then_has_time_to_begin(watch: Watch) -> None:
    running = watch.running_role("gyro_left", "imu")
    paused = replace(running, topics=[replace(running.topics[0], is_running=False)])
    watch.receive(*range(10))
    row = watch.topic(paused)
    assert (row.level, row.message) == (Level.OK, "paused")
    assert watch.states(paused, 100.0) == {"gyro_left": "paused"}
    assert watch.states(running, 108.0) == {"gyro_left": "running"}
    assert watch.states(running, 109.0)["gyro_left"].startswith("silent: ")


@pytest.mark.parametrize(
    ("state", "text"),
    [
        (State.ENDED, "paused: the session has ended"),
        (State.LOST, "silent: the connection is lost"),
    ],
)
def test_without_a_connection_no_stream_runs(watch: Watch, state: State, text: str) -> None:
    watch.receive(*range(10))
    running = dict.fromkeys(("gyro_left", "custom"), StreamStatus("running"))
    told = watch.running_role("gyro_left", "imu", state=state, streams=running)
    assert watch.states(told) == {"gyro_left": text, "custom": text}


def test_a_stream_runs_although_one_of_its_topics_is_switched_off(watch: Watch) -> None:
    watch.receive(*range(10))
    image, *_, confidence, _ = load_table().streams["depth"].topics
    off = replace(watch.topic_report(confidence), is_running=False)
    told = watch.running("depth", watch.topic_report(image), off)
    assert watch.states(told) == {"depth": "running"}


def test_a_reason_of_a_running_stream_hides_no_silence(watch: Watch) -> None:
    states = {"gyro_left": StreamStatus("running", "as it says")}
    told = watch.running_role("gyro_left", "imu", streams=states)
    assert watch.states(told)["gyro_left"].startswith("waiting: ")
    assert watch.states(told, 9.0)["gyro_left"].startswith("silent: ")


def test_one_silent_topic_of_a_stream_is_enough(watch: Watch) -> None:
    image, info, *_ = load_table().streams["world_left"].topics
    delivering, silent = TopicStatistics(), TopicStatistics()
    receive(silent, *range(10))
    for second in range(4):
        receive(delivering, *range(second * 10, second * 10 + 10))
        topics = [TopicReport(image, delivering, None), TopicReport(info, silent, None)]
        found = watch.states(watch.running("world_left", *topics, answers=AT_30_HZ), second)
    assert found == {"world_left": "silent: nothing has come for 3 s, expected 30 Hz"}


def test_a_stream_of_an_app_may_be_silent(watch: Watch) -> None:
    custom = load_table().custom_topics.topic("custom/words", "std_msgs/msg/String")
    assert custom is not None
    told = watch.running("custom", watch.topic_report(custom))
    assert [watch.states(told, it)["custom"] for it in (0.0, 1e4)] == ["running"] * 2


@pytest.mark.parametrize("rate", [0, -1, "30"])
def test_a_promised_rate_that_is_none_is_ignored(watch: Watch, rate: Any) -> None:
    watch.receive(*range(10))
    answers = {"world_left": StreamAnswer("applied", {"update_rate": rate})}
    told = watch.report(answers=answers)
    assert "expected_hz" not in watch.topic(told).values
    message = watch.topic(told, 5.0).message
    assert message == "silent: nothing has come for 5 s, expected a message every 4 s"

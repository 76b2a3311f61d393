from dataclasses import replace
from typing import Any

import pytest

from ml2_receiver.session.report import Report, State, TopicReport
from ml2_receiver.session.statistics import TopicStatistics
from ml2_receiver.session.stream_state import Judgement
from ml2_receiver.session.throughput import Throughput
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.diagnostics import Diagnostics, Level, Row
from ml2_receiver.topics.judgement import read_judgements
from ml2_receiver.wire.frame import MAGIC, VERSION, Header
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import (
    ChannelStatus,
    ClockStatus,
    StreamAnswer,
    StreamStatus,
    Thermal,
)
from ml2_tools.doctor.devices import DeviceStream, read_device

TOPIC = load_table().streams["world_left"].topics[0]
MS = 1_000_000
SENT_ALL = ChannelStatus(10, 10, {})


@pytest.fixture
def statistics() -> TopicStatistics:
    return TopicStatistics()


@pytest.fixture
def diagnostics() -> Diagnostics:
    return Diagnostics("/prefix")


def report(
    statistics: TopicStatistics,
    device: ChannelStatus | None = None,
    state: State = State.CONNECTED,
) -> Report:
    clock = ClockStatus("synchronised", -5, 6, 7)
    return Report(state, "Zoë", "id", clock, 3, True, [TopicReport(TOPIC, statistics, device)])


def receive(statistics: TopicStatistics, *sequences: int) -> None:
    for sequence in sequences:
        capture_ns = sequence * 100_000_000
        header = Header(
            MAGIC, VERSION, Kind.DATA, 0, 1, sequence, 125_000, capture_ns, capture_ns + MS
        )
        statistics.record(header, capture_ns + 4 * MS, capture_ns + 4 * MS + 500_000)


def topic_row(diagnostics: Diagnostics, report: Report, now_s: float) -> Row:
    *_, row = diagnostics.rows(report, now_s)
    return row


def test_without_a_headset_there_is_a_row_that_says_so(diagnostics: Diagnostics) -> None:
    (row,) = diagnostics.rows(None, 0.0)
    assert (row.name, row.level, row.values) == ("session", Level.OK, {"state": "waiting"})


def test_the_session_has_a_row(diagnostics: Diagnostics, statistics: TopicStatistics) -> None:
    row, *_ = diagnostics.rows(report(statistics), 0.0)
    assert (row.name, row.level) == ("session", Level.OK)
    assert row.values == {
        "state": "connected",
        "headset": "Zoë",
        "device_id": "id",
        "skipped_frames": "3",
        "final": "true",
        "software": "",
        "capabilities": "",
    }


@pytest.mark.parametrize(
    ("thermal", "level"), [("none", Level.OK), ("moderate", Level.OK), ("severe", Level.WARN)]
)
def test_a_hot_headset_is_a_warning(thermal: Thermal, level: Level) -> None:
    hot = replace(report(TopicStatistics()), thermal=thermal)
    row, *_ = Diagnostics("").rows(hot, 0.0)
    assert row.level == level
    assert row.values["thermal"] == thermal
    assert (thermal in row.message) == (level == Level.WARN)


FULL_CLOCK = ClockStatus(
    "synchronised", -5, 6000, 7, -49.5, 1, 2, {"color": "monotonic", "imu_left": "boottime"}
)


def clock_row(clock: ClockStatus) -> Row:
    _, row, *_ = Diagnostics("/prefix").rows(replace(report(TopicStatistics()), clock=clock), 0.0)
    return row


def test_the_clock_has_a_row() -> None:
    row = clock_row(FULL_CLOCK)
    assert (row.name, row.level) == ("clock", Level.OK)
    assert row.message == "synchronised, stamps within 0.006 ms of the capture"
    assert row.values == {
        "state": "synchronised",
        "offset_ns": "-5",
        "uncertainty_ns": "6000",
        "round_trip_ns": "7",
        "skew_ppm": "-49.5",
        "steps": "1",
        "epoch": "2",
        "bases.color": "monotonic",
        "bases.imu_left": "boottime",
    }


def test_what_a_device_does_not_say_of_its_clock_is_absent() -> None:
    row = clock_row(ClockStatus("synchronised", -5, 6, 7))
    assert list(row.values) == ["state", "offset_ns", "uncertainty_ns", "round_trip_ns"]


def test_before_the_first_status_there_is_no_clock() -> None:
    rows = Diagnostics("").rows(replace(report(TopicStatistics()), clock=None), 0.0)
    assert "clock" not in [row.name for row in rows]


@pytest.mark.parametrize(
    ("changes", "level"),
    [
        ({"state": "holdover"}, Level.WARN),
        ({"state": "frozen"}, Level.OK),
        ({"uncertainty_ns": 5 * MS}, Level.OK),
        ({"uncertainty_ns": 5 * MS + 1}, Level.WARN),
    ],
)
def test_holdover_and_more_than_5_ms_are_warnings(changes: dict[str, Any], level: Level) -> None:
    assert clock_row(replace(FULL_CLOCK, **changes)).level == level


def test_a_lost_session_is_an_error(diagnostics: Diagnostics, statistics: TopicStatistics) -> None:
    rows = diagnostics.rows(report(statistics, state=State.LOST), 0.0)
    assert [row.level for row in rows] == [Level.ERROR, Level.OK, Level.ERROR]
    rows = diagnostics.rows(report(statistics, state=State.ENDED), 0.0)
    assert {row.level for row in rows} == {Level.OK}


def test_rates_are_of_the_time_since_the_last_call(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, 0)
    assert topic_row(diagnostics, report(statistics), 10.0).values["rate_hz"] == "0.00"
    receive(statistics, 1, 2, 3)
    values = topic_row(diagnostics, report(statistics), 12.0).values
    assert (values["rate_hz"], values["mbit_per_s"]) == ("1.50", "1.50")


def test_a_topic_has_its_numbers(diagnostics: Diagnostics, statistics: TopicStatistics) -> None:
    receive(statistics, 0, 2)
    device = ChannelStatus(4, 3, {"queue_full": 1, "link_down": 0})
    row = topic_row(diagnostics, report(statistics, device), 1.0)
    assert row.name == "/prefix/world_left/image_raw"
    assert row.values == {
        "stream": "world_left",
        "type": "sensor_msgs/msg/Image",
        "rate_hz": "0.00",
        "mbit_per_s": "0.00",
        "received": "2",
        "gaps": "1",
        "unpublished": "0",
        "produced": "4",
        "sent": "3",
        "dropped.queue_full": "1",
        "dropped.link_down": "0",
        "latency_p50_ms": "4.000",
        "latency_p99_ms": "4.000",
        "latency_jitter_ms": "0.000",
        "window.messages": "2",
        "window.first_capture_ns": "0",
        "window.last_capture_ns": "200000000",
        "window.capture_to_sent_ms": "1.000",
        "window.sent_to_received_ms": "3.000",
        "window.received_to_published_ms": "0.500",
    }
    assert (row.level, row.message) == (Level.WARN, "lost messages: 1")


def test_a_window_has_the_messages_since_the_last_call(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    windows = []
    for sequences in ((0, 1), (2,), ()):
        receive(statistics, *sequences)
        values = topic_row(diagnostics, report(statistics), 0.0).values
        windows.append((values["window.messages"], values.get("window.last_capture_ns")))
    assert windows == [("2", "100000000"), ("1", "200000000"), ("0", None)]


def test_shares_are_unknown_while_the_device_does_not_know_ros_time(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, 0)
    header = Header(MAGIC, VERSION, Kind.DATA, 0, 1, 1, 10, 5, 0)
    statistics.record(header, 6, 7)
    values = topic_row(diagnostics, report(statistics), 0.0).values
    assert values["window.messages"] == "2"
    assert "window.capture_to_sent_ms" not in values


def test_at_the_end_messages_lost_after_the_last_arrival_are_gaps(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, 0, 2)
    device = ChannelStatus(5, 2, {"queue_full": 1, "link_down": 2})
    under_way = topic_row(diagnostics, report(statistics, device), 1.0)
    over = topic_row(diagnostics, report(statistics, device, State.ENDED), 1.0)
    assert (under_way.values["gaps"], over.values["gaps"]) == ("1", "3")


@pytest.mark.parametrize(("sent", "dropped"), [(4, 1), (3, 2), (2, 3), (1, 4)])
def test_at_the_end_what_was_sent_in_vain_is_dropped_by_the_link(
    diagnostics: Diagnostics, statistics: TopicStatistics, sent: int, dropped: int
) -> None:
    receive(statistics, 0, 2)
    device = ChannelStatus(sent + dropped, sent, {"link_down": dropped})
    values = topic_row(diagnostics, report(statistics, device, State.ENDED), 1.0).values
    assert values["dropped.link_down"] == values["gaps"] == "3"


@pytest.mark.parametrize(
    ("sequences", "dropped", "unpublished"),
    [((0, 2), {}, 0), ((0, 1), {"no_buffer": 1}, 0), ((0, 1), {}, 1)],
)
def test_any_loss_is_a_warning(
    diagnostics: Diagnostics, sequences: tuple[int, ...], dropped: dict[str, int], unpublished: int
) -> None:
    statistics = TopicStatistics()
    receive(statistics, *sequences)
    statistics.unpublished = unpublished
    device = ChannelStatus(2, 2, dropped)
    assert topic_row(diagnostics, report(statistics, device), 1.0).level == Level.WARN
    assert topic_row(diagnostics, report(statistics, SENT_ALL), 1.0).message != ""


def test_a_topic_is_stale_when_the_device_produces_and_nothing_arrives(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    levels = []
    for second in range(6):
        device = replace(SENT_ALL, produced=10 + second)
        if second < 2:
            receive(statistics, second)
        levels.append(topic_row(diagnostics, report(statistics, device), float(second)).level)
    assert levels == [Level.OK] * 4 + [Level.ERROR] * 2


@pytest.mark.parametrize("dropped", [0, 2])
def test_a_status_that_counts_late_makes_no_topic_stale(
    diagnostics: Diagnostics, statistics: TopicStatistics, dropped: int
) -> None:
    receive(statistics, *range(10))
    told = told_of("battery", "battery", statistics)
    for second, missing in enumerate((5, 2, 0, 0, 0, 0)):
        produced = 10 + dropped - missing
        device = ChannelStatus(produced, produced - dropped, {"queue_full": dropped})
        late = replace(told, topics=[replace(told.topics[0], device=device)])
        assert states(diagnostics, late, float(second)) == {"battery": "running"}


def test_a_sensor_that_has_nothing_to_say_is_not_stale(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, *range(10))
    for second in range(6):
        row = topic_row(diagnostics, told_of("battery", "battery", statistics), float(second))
        assert row.level == Level.OK


def test_the_session_tells_what_the_headset_can_and_may_and_answered(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    answers = {
        "world_left": StreamAnswer("applied", {"update_rate": 30}),
        "gaze": StreamAnswer("refused", None, "not calibrated"),
    }
    told = replace(
        report(statistics),
        software="app 1",
        capabilities=["world_left", "gaze"],
        permissions={"android.permission.CAMERA": False},
        answers=answers,
    )
    session, *_, topic = diagnostics.rows(told, 0.0)
    assert session.values["software"] == "app 1"
    assert session.values["capabilities"] == "world_left gaze"
    assert session.values["permission.android.permission.CAMERA"] == "false"
    assert session.values["stream.world_left"] == "applied"
    assert session.values["stream.gaze"] == "refused: not calibrated"
    assert topic.values["expected_hz"] == "30"


CAMERA = "android.permission.CAMERA"
AT_30_HZ = {"world_left": StreamAnswer("applied", {"update_rate": 30})}


@pytest.mark.parametrize(
    ("status", "level"),
    [
        (StreamStatus("waiting", "taken away", CAMERA), Level.WARN),
        (StreamStatus("refused", "not granted", CAMERA), Level.WARN),
        (StreamStatus("failed", "broken"), Level.ERROR),
    ],
)
def test_a_stream_that_does_not_run_is_never_ok(
    diagnostics: Diagnostics, statistics: TopicStatistics, status: StreamStatus, level: Level
) -> None:
    told = replace(report(statistics, SENT_ALL), answers=AT_30_HZ, streams={"world_left": status})
    session, *_, topic = diagnostics.rows(told, 0.0)
    assert (session.level, topic.level) == (Level.WARN, level)
    assert session.values["state.world_left"] == f"{status.state}: {status.reason}"
    assert session.values.get("missing.world_left") == status.permission
    for row in (session, topic):
        assert f"{status.state}: {status.reason}" in row.message
        fix = f"{CAMERA} is missing: run `ml2-receiver headset grant world_left`"
        assert (fix in row.message) == (status.permission is not None)


def test_a_camera_that_has_sent_nothing_yet_is_waited_for(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    told = replace(report(statistics, ChannelStatus(0, 0, {})), answers=AT_30_HZ)
    row = topic_row(diagnostics, told, 0.0)
    assert (row.level, row.message) == (Level.WARN, "waiting: no message has come yet")


def test_a_camera_that_sends_nothing_any_more_is_an_error(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, *range(10))
    told = replace(report(statistics, SENT_ALL), answers=AT_30_HZ)
    levels = [topic_row(diagnostics, told, float(second)).level for second in range(5)]
    assert levels == [Level.OK] * 3 + [Level.ERROR] * 2
    assert "expected 30 Hz" in topic_row(diagnostics, told, 5.0).message


def lowered(statistics: TopicStatistics, **streams: StreamStatus) -> Report:
    return replace(report(statistics, SENT_ALL), answers=AT_30_HZ, streams=streams)


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
    statistics: TopicStatistics,
    streams: dict[str, StreamStatus],
    level: Level,
    message: str,
    values: dict[str, str],
) -> None:
    rows = Diagnostics("").rows(lowered(statistics, **streams), 0.0)
    (row,) = [row for row in rows if row.name == "adaptation"]
    assert (row.level, row.message, row.values) == (level, message, values)


@pytest.mark.parametrize("state", [State.ENDED, State.LOST])
def test_without_a_connection_nothing_gives_way(
    diagnostics: Diagnostics, statistics: TopicStatistics, state: State
) -> None:
    told = replace(lowered(statistics, world_left=LOWERED), state=state)
    assert "adaptation" not in [row.name for row in diagnostics.rows(told, 0.0)]


def test_a_lowered_rate_is_what_a_camera_is_judged_by(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    slow = lowered(statistics, world_left=StreamStatus("running", rate_hz=1))
    receive(statistics, *range(10))
    row = topic_row(diagnostics, slow, 0.0)
    assert (row.level, row.values["expected_hz"]) == (Level.OK, "1")
    session, *_, topic = diagnostics.rows(slow, 3.0)
    assert (session.level, topic.level) == (Level.WARN, Level.ERROR)
    assert topic.message == "silent: nothing has come for 3 s, expected 1 Hz"
    back = lowered(statistics, world_left=StreamStatus("running", quality=60))
    assert topic_row(diagnostics, back, 3.0).values["expected_hz"] == "30"


def test_a_stream_that_gives_way_is_well(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, *range(10))
    session, *_, topic = diagnostics.rows(lowered(statistics, world_left=LOWERED), 0.0)
    assert (session.level, topic.level) == (Level.OK, Level.OK)
    assert session.values["state.world_left"] == "running"


def told_of(stream: str, role: str, statistics: TopicStatistics) -> Report:
    """A session with one topic whose headset says that the stream runs."""
    topics = load_table().streams[stream].topics
    (topic,) = [it for it in topics if it.role == role]
    device = ChannelStatus(statistics.received, statistics.received, {})
    told = replace(report(statistics), topics=[TopicReport(topic, statistics, device)])
    return replace(told, streams={stream: StreamStatus("running")})


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
        ("light_sensor", "illuminance", 60, "a message every 60 s"),
        ("battery", "battery", 600, "a message every 600 s"),
    ],
)
def test_a_stream_is_silent_after_its_longest_pause(
    diagnostics: Diagnostics,
    statistics: TopicStatistics,
    stream: str,
    role: str,
    pause_s: int,
    expected: str,
) -> None:
    receive(statistics, *range(10))
    told = told_of(stream, role, statistics)
    assert topic_row(diagnostics, told, 0.0).level == Level.OK
    assert topic_row(diagnostics, told, float(pause_s)).level == Level.OK
    session, *_, topic = diagnostics.rows(told, pause_s + 1.0)
    words = f"nothing has come for {pause_s + 1} s, expected {expected}"
    assert (topic.level, topic.message) == (Level.ERROR, f"silent: {words}")
    assert session.level == Level.WARN
    assert read_judgements(session.values) == {stream: Judgement("silent", words)}
    device = read_device({"session": session.values}, load_table())
    assert device is not None
    assert DeviceStream(stream, "silent", words) in device.streams
    receive(statistics, *range(10, 20))
    session, *_, topic = diagnostics.rows(told_of(stream, role, statistics), pause_s + 2.0)
    assert (session.level, topic.level) == (Level.OK, Level.OK)


def test_a_stream_that_never_delivers_is_not_waited_for_for_ever(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    told = told_of("gyro_left", "imu", statistics)
    rows = [topic_row(diagnostics, told, float(second)) for second in range(10)]
    assert {row.message for row in rows[:9]} == {"waiting: no message has come yet"}
    assert rows[9].level == Level.ERROR
    assert rows[9].message.startswith("silent: nothing has come for 9 s")


@pytest.mark.parametrize(("stream", "role"), [("tf", "tf_static")])
def test_a_latched_topic_may_be_silent(
    diagnostics: Diagnostics, statistics: TopicStatistics, stream: str, role: str
) -> None:
    receive(statistics, 0)
    told = told_of(stream, role, statistics)
    assert {topic_row(diagnostics, told, float(it)).level for it in range(100)} == {Level.OK}


def states(diagnostics: Diagnostics, told: Report, now_s: float) -> dict[str, str]:
    session, *_ = diagnostics.rows(told, now_s)
    return {id: it.text for id, it in read_judgements(session.values).items()}


def test_a_topic_that_is_not_to_run_is_paused_and_then_has_time_to_begin(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    running = told_of("gyro_left", "imu", statistics)
    paused = replace(running, topics=[replace(running.topics[0], is_running=False)])
    receive(statistics, *range(10))
    row = topic_row(diagnostics, paused, 0.0)
    assert (row.level, row.message) == (Level.OK, "paused")
    assert states(diagnostics, paused, 100.0) == {"gyro_left": "paused"}
    assert states(diagnostics, running, 108.0) == {"gyro_left": "running"}
    assert states(diagnostics, running, 109.0)["gyro_left"].startswith("silent: ")


@pytest.mark.parametrize(
    ("state", "text"),
    [
        (State.ENDED, "paused: the session has ended"),
        (State.LOST, "silent: the connection is lost"),
    ],
)
def test_without_a_connection_no_stream_runs(
    diagnostics: Diagnostics, statistics: TopicStatistics, state: State, text: str
) -> None:
    receive(statistics, *range(10))
    told = replace(told_of("gyro_left", "imu", statistics), state=state)
    told = replace(told, streams={**told.streams, "custom": StreamStatus("running")})
    assert states(diagnostics, told, 0.0) == {"gyro_left": text, "custom": text}


def test_a_stream_runs_although_one_of_its_topics_is_switched_off(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    receive(statistics, *range(10))
    image, *_, confidence, _ = load_table().streams["depth"].topics
    on, off = TopicReport(image, statistics, None), TopicReport(confidence, statistics, None)
    told = replace(report(statistics), topics=[on, replace(off, is_running=False)])
    told = replace(told, streams={"depth": StreamStatus("running")})
    assert states(diagnostics, told, 0.0) == {"depth": "running"}


@pytest.mark.parametrize(
    ("format", "of_raw", "of_compressed"),
    [
        ("jpeg", {"needs": "format=Grayscale"}, {"expected_hz": "30"}),
        ("Grayscale", {"expected_hz": "30"}, {"needs": "format=jpeg"}),
    ],
)
def test_a_topic_of_another_format_is_not_expected(
    diagnostics: Diagnostics,
    statistics: TopicStatistics,
    format: str,
    of_raw: dict[str, str],
    of_compressed: dict[str, str],
) -> None:
    images = [it for it in load_table().streams["world_left"].topics if "image_raw" in it.name]
    topics = [TopicReport(it, statistics, None) for it in images]
    answer = StreamAnswer("applied", {"format": format, "update_rate": 30})
    told = replace(report(statistics), topics=topics, answers={"world_left": answer})
    *_, raw, compressed, video, foxglove = diagnostics.rows(told, 0.0)
    assert compressed.name.endswith("/compressed")
    assert video.values["needs"] == "format=h264"
    assert foxglove.values["needs"] == "format=h264_foxglove"
    for row, expected in ((raw, of_raw), (compressed, of_compressed)):
        found = {key: row.values[key] for key in ("needs", "expected_hz") if key in row.values}
        assert found == expected


def test_a_reason_of_a_running_stream_hides_no_silence(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    told = told_of("gyro_left", "imu", statistics)
    told = replace(told, streams={"gyro_left": StreamStatus("running", "as it says")})
    assert states(diagnostics, told, 0.0)["gyro_left"].startswith("waiting: ")
    assert states(diagnostics, told, 9.0)["gyro_left"].startswith("silent: ")


def test_one_silent_topic_of_a_stream_is_enough(diagnostics: Diagnostics) -> None:
    image, info, *_ = load_table().streams["world_left"].topics
    delivering, silent = TopicStatistics(), TopicStatistics()
    receive(silent, *range(10))
    for second in range(4):
        receive(delivering, *range(second * 10, second * 10 + 10))
        topics = [TopicReport(image, delivering, None), TopicReport(info, silent, None)]
        told = replace(report(silent), topics=topics, answers=AT_30_HZ)
        told = replace(told, streams={"world_left": StreamStatus("running")})
        found = states(diagnostics, told, float(second))
    assert found == {"world_left": "silent: nothing has come for 3 s, expected 30 Hz"}


def test_a_stream_of_an_app_may_be_silent(
    diagnostics: Diagnostics, statistics: TopicStatistics
) -> None:
    custom = load_table().custom_topics.topic("custom/words", "std_msgs/msg/String")
    assert custom is not None
    told = replace(report(statistics), topics=[TopicReport(custom, statistics, None)])
    told = replace(told, streams={"custom": StreamStatus("running")})
    assert [states(diagnostics, told, it)["custom"] for it in (0.0, 1e4)] == ["running"] * 2


@pytest.mark.parametrize("rate", [0, -1, "30"])
def test_a_promised_rate_that_is_none_is_ignored(
    diagnostics: Diagnostics, statistics: TopicStatistics, rate: Any
) -> None:
    receive(statistics, *range(10))
    answers = {"world_left": StreamAnswer("applied", {"update_rate": rate})}
    told = replace(report(statistics), answers=answers)
    assert "expected_hz" not in topic_row(diagnostics, told, 0.0).values
    message = topic_row(diagnostics, told, 5.0).message
    assert message == "silent: nothing has come for 5 s, expected a message every 4 s"


@pytest.mark.parametrize(
    ("link", "level", "values"),
    [
        (Throughput(1, "running"), Level.OK, {}),
        (Throughput(2, "unanswered"), Level.WARN, {}),
        (
            Throughput(3, "measured", 67_108_864, 1.25, 412.345, 250.0),
            Level.OK,
            {
                "filler_bytes": "67108864",
                "duration_s": "1.250",
                "free_mbit_per_s": "412.35",
                "streams_mbit_per_s": "250.00",
            },
        ),
    ],
)
def test_a_link_test_has_a_row(
    diagnostics: Diagnostics,
    statistics: TopicStatistics,
    link: Throughput,
    level: Level,
    values: dict[str, str],
) -> None:
    assert all(row.name != "link" for row in diagnostics.rows(report(statistics), 0.0))
    rows = diagnostics.rows(replace(report(statistics), link=link), 1.0)
    (row,) = [row for row in rows if row.name == "link"]
    assert row.level == level
    assert row.values == {"state": link.state, "tests": str(link.number)} | values

"""Rows of diagnostics: the session, its clock, and the numbers of topics and link."""

from collections import Counter
from dataclasses import replace
from typing import Any

import pytest

from diagnostics_scene import MS, SENT_ALL, Watch
from ml2_receiver.session.link_tests import LinkTestResult
from ml2_receiver.session.report import CallsReport, OpeningsReport, State
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.diagnostics import Level, Row
from ml2_receiver.wire.frame import MAGIC, VERSION, Header
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import (
    ChannelStatus,
    ClockStatus,
    Condition,
    StreamAnswer,
    Thermal,
)
from ml2_receiver.wire.opening_bodies import CallStatus


@pytest.fixture
def watch() -> Watch:
    return Watch()


def test_without_a_headset_there_is_a_row_that_says_so(watch: Watch) -> None:
    (row,) = watch.rows(None)
    assert (row.name, row.level, row.values) == ("session", Level.OK, {"state": "waiting"})


def test_the_session_has_a_row(watch: Watch) -> None:
    row, *_ = watch.rows(watch.report())
    assert (row.name, row.level) == ("session", Level.OK)
    assert row.values == {
        "state": "connected",
        "headset": "Zoë",
        "device_id": "id",
        "skipped_frames": "3",
        "late_frames": "0",
        "final": "true",
        "software": "",
        "capabilities": "",
    }


def test_services_of_the_app_have_rows_with_the_counts_of_both_sides(watch: Watch) -> None:
    counts = Counter({Kind.REQUEST: 4, Kind.RESPONSE: 2, Kind.FAILURE: 1})
    device = CallStatus(9, 5, {"cancelled": 1, "link_down": 2})
    client = CallsReport(3, "client", "/pause", "std_srvs/srv/SetBool", counts, device)
    service = CallsReport(4, "service", "/on", "std_srvs/srv/Trigger", Counter(), None)
    rows = watch.rows(watch.report(openings=OpeningsReport(calls=[client, service])))
    assert [(row.name, row.values) for row in rows[-2:]] == [
        (
            "client /pause",
            {
                "id": "3",
                "service_type": "std_srvs/srv/SetBool",
                "requests": "4",
                "responses": "2",
                "failures": "1",
                "app.requests": "9",
                "app.responses": "5",
                "app.failures.cancelled": "1",
                "app.failures.link_down": "2",
            },
        ),
        (
            "service /on",
            {
                "id": "4",
                "service_type": "std_srvs/srv/Trigger",
                "requests": "0",
                "responses": "0",
                "failures": "0",
            },
        ),
    ]


@pytest.mark.parametrize(
    ("thermal", "level"), [("none", Level.OK), ("moderate", Level.OK), ("severe", Level.WARN)]
)
def test_a_hot_headset_is_a_warning(watch: Watch, thermal: Thermal, level: Level) -> None:
    row, *_ = watch.rows(watch.report(thermal=thermal))
    assert row.level == level
    assert row.values["thermal"] == thermal
    assert (thermal in row.message) == (level == Level.WARN)


def test_what_the_headset_perceives_has_rows_while_it_is_connected(watch: Watch) -> None:
    conditions = {
        "map": Condition("ok", "localized in Lab", {"name": "Lab"}),
        "gaze": Condition("warn", "headset fit is bad", {"headset_fit": "bad"}),
    }
    report = watch.report(conditions=conditions)
    found = [it for it in watch.rows(report) if it.name.startswith("headset ")]
    assert found == [
        Row("headset gaze", Level.WARN, "headset fit is bad", {"headset_fit": "bad"}),
        Row("headset map", Level.OK, "localized in Lab", {"name": "Lab"}),
    ]
    gone = replace(report, state=State.LOST)
    assert not [it for it in watch.rows(gone) if it.name.startswith("headset ")]


FULL_CLOCK = ClockStatus(
    "synchronised", -5, 6000, 7, -49.5, 1, 2, {"color": "monotonic", "imu_left": "boottime"}
)


def clock_row(clock: ClockStatus) -> Row:
    watch = Watch()
    (row,) = watch.named("clock", watch.report(clock=clock))
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


def test_before_the_first_status_there_is_no_clock(watch: Watch) -> None:
    assert watch.named("clock", watch.report(clock=None)) == []


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


def test_a_lost_session_is_an_error(watch: Watch) -> None:
    rows = watch.rows(watch.report(state=State.LOST))
    assert [row.level for row in rows] == [Level.ERROR, Level.OK, Level.ERROR]
    rows = watch.rows(watch.report(state=State.ENDED))
    assert {row.level for row in rows} == {Level.OK}


def test_rates_are_of_the_time_since_the_last_call(watch: Watch) -> None:
    watch.receive(0)
    assert watch.topic(watch.report(), 10.0).values["rate_hz"] == "0.00"
    watch.receive(1, 2, 3)
    values = watch.topic(watch.report(), 12.0).values
    assert (values["rate_hz"], values["mbit_per_s"]) == ("1.50", "1.50")


def test_a_camera_that_accepts_60_hz_and_delivers_30_is_shown_as_it_comes(watch: Watch) -> None:
    answers = {"depth": StreamAnswer("applied", {"stream": 1, "update_rate": 60})}
    topic = watch.topic_report(load_table().streams["depth"].topics[0], SENT_ALL)
    report = watch.running("depth", topic, answers=answers)
    watch.receive(0)
    watch.topic(report, 10.0)
    watch.receive(*range(1, 61))
    row = watch.topic(report, 12.0)
    assert (row.values["rate_hz"], row.values["expected_hz"]) == ("30.00", "60")
    assert row.level == Level.OK


def test_a_topic_has_its_numbers(watch: Watch) -> None:
    watch.receive(0, 2)
    device = ChannelStatus(4, 3, {"queue_full": 1, "link_down": 0})
    row = watch.topic(watch.report(device), 1.0)
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


def test_a_window_has_the_messages_since_the_last_call(watch: Watch) -> None:
    windows = []
    for sequences in ((0, 1), (2,), ()):
        watch.receive(*sequences)
        values = watch.topic(watch.report()).values
        windows.append((values["window.messages"], values.get("window.last_capture_ns")))
    assert windows == [("2", "100000000"), ("1", "200000000"), ("0", None)]


def test_shares_are_unknown_while_the_device_does_not_know_ros_time(watch: Watch) -> None:
    watch.receive(0)
    header = Header(MAGIC, VERSION, Kind.DATA, 0, 1, 1, 10, 5, 0)
    watch.statistics.record(header, 6, 7)
    values = watch.topic(watch.report()).values
    assert values["window.messages"] == "2"
    assert "window.capture_to_sent_ms" not in values


def test_at_the_end_messages_lost_after_the_last_arrival_are_gaps(watch: Watch) -> None:
    watch.receive(0, 2)
    device = ChannelStatus(5, 2, {"queue_full": 1, "link_down": 2})
    under_way = watch.topic(watch.report(device), 1.0)
    over = watch.topic(watch.report(device, state=State.ENDED), 1.0)
    assert (under_way.values["gaps"], over.values["gaps"]) == ("1", "3")


@pytest.mark.parametrize(("sent", "dropped"), [(4, 1), (3, 2), (2, 3), (1, 4)])
def test_at_the_end_what_was_sent_in_vain_is_dropped_by_the_link(
    watch: Watch, sent: int, dropped: int
) -> None:
    watch.receive(0, 2)
    device = ChannelStatus(sent + dropped, sent, {"link_down": dropped})
    values = watch.topic(watch.report(device, state=State.ENDED), 1.0).values
    assert values["dropped.link_down"] == values["gaps"] == "3"


@pytest.mark.parametrize(
    ("sequences", "dropped", "unpublished"),
    [((0, 2), {}, 0), ((0, 1), {"no_buffer": 1}, 0), ((0, 1), {}, 1)],
)
def test_any_loss_is_a_warning(
    watch: Watch, sequences: tuple[int, ...], dropped: dict[str, int], unpublished: int
) -> None:
    watch.receive(*sequences)
    watch.statistics.unpublished = unpublished
    device = ChannelStatus(2, 2, dropped)
    assert watch.topic(watch.report(device), 1.0).level == Level.WARN
    assert watch.topic(watch.report(SENT_ALL), 1.0).message != ""


def test_the_session_tells_what_the_headset_can_and_may_and_answered(watch: Watch) -> None:
    answers = {
        "world_left": StreamAnswer("applied", {"update_rate": 30}),
        "gaze": StreamAnswer("refused", None, "not calibrated"),
    }
    told = watch.report(
        software="app 1",
        capabilities=["world_left", "gaze"],
        permissions={"android.permission.CAMERA": False},
        answers=answers,
    )
    session, *_, topic = watch.rows(told)
    assert session.values["software"] == "app 1"
    assert session.values["capabilities"] == "world_left gaze"
    assert session.values["permission.android.permission.CAMERA"] == "false"
    assert session.values["stream.world_left"] == "applied"
    assert session.values["stream.gaze"] == "refused: not calibrated"
    assert topic.values["expected_hz"] == "30"


@pytest.mark.parametrize(
    ("format", "of_raw", "of_compressed"),
    [
        ("jpeg", {"needs": "format=Grayscale"}, {"expected_hz": "30"}),
        ("Grayscale", {"expected_hz": "30"}, {"needs": "format=jpeg"}),
    ],
)
def test_a_topic_of_another_format_is_not_expected(
    watch: Watch, format: str, of_raw: dict[str, str], of_compressed: dict[str, str]
) -> None:
    images = [it for it in load_table().streams["world_left"].topics if "image_raw" in it.name]
    topics = [watch.topic_report(it) for it in images]
    answer = StreamAnswer("applied", {"format": format, "update_rate": 30})
    told = watch.report(topics=topics, answers={"world_left": answer})
    *_, raw, compressed, video, foxglove = watch.rows(told)
    assert compressed.name.endswith("/compressed")
    assert video.values["needs"] == "format=h264"
    assert foxglove.values["needs"] == "format=h264_foxglove"
    for row, expected in ((raw, of_raw), (compressed, of_compressed)):
        found = {key: row.values[key] for key in ("needs", "expected_hz") if key in row.values}
        assert found == expected


@pytest.mark.parametrize(
    ("link", "level", "values"),
    [
        (LinkTestResult(1, "running"), Level.OK, {}),
        (LinkTestResult(2, "unanswered"), Level.WARN, {}),
        (
            LinkTestResult(3, "measured", 67_108_864, 1.25, 412.345, 250.0),
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
    watch: Watch, link: LinkTestResult, level: Level, values: dict[str, str]
) -> None:
    assert watch.named("link", watch.report()) == []
    (row,) = watch.named("link", watch.report(link_test=link))
    assert row.level == level
    assert row.values == {"state": link.state, "tests": str(link.number)} | values

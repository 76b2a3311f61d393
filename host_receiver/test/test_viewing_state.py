"""The state and the curves that `ml2-receiver view` shows, of rows of diagnostics."""

import pytest

from ml2_tools.viewing.fields import fields_of, plottable_topics, topic_fields
from ml2_tools.viewing.losses import RecentLosses
from ml2_tools.viewing.plots import Series
from ml2_tools.viewing.state import state_of, topic_prefix

WORLD = "/magic_leap2/world_left/image_raw"
ROWS = {
    "session": {
        "message": "head: connected",
        "headset": "head",
        "state": "connected",
        "state.world_left": "running",
    },
    "adaptation": {"world_left.rate_hz": "15", "message": "lowered for the link: world_left"},
    "security": {"message": "insecure: no encryption"},
    WORLD: {
        "stream": "world_left",
        "type": "sensor_msgs/msg/Image",
        "rate_hz": "14.9",
        "expected_hz": "15",
        "received": "100",
        "gaps": "2",
        "unpublished": "1",
        "latency_p50_ms": "12.5",
        "window.capture_to_sent_ms": "10.5",
        "window.sent_to_received_ms": "1.25",
        "window.received_to_published_ms": "0.75",
        "message": "lost messages: 2",
    },
    "/magic_leap2/battery": {
        "stream": "battery",
        "type": "sensor_msgs/msg/BatteryState",
        "received": "7",
        "gaps": "4",
        "unpublished": "0",
        "message": "lost messages: 4",
    },
}


def test_what_the_headset_adjusted_is_said_with_the_reason() -> None:
    session = ROWS["session"] | {"stream.world_left": "adjusted: the device has 30 Hz"}
    state = state_of(ROWS | {"session": session}, {}, {}, "")
    assert state["applied"] == {"world_left": "running, adjusted: the device has 30 Hz"}


@pytest.mark.parametrize(("period_s", "kept"), [(0.03125, 961), (0.5, 61), (40, 1)])
def test_a_series_gives_each_value_once_and_has_those_of_30_s(period_s: float, kept: int) -> None:
    series = Series()
    for number in range(3000):
        series.add((number, float("nan")), 1000 + period_s * number)
    count, values = series.since(2999)
    assert (count, [it for _, it in values]) == (3000, [(2999, None)])
    assert series.since(3000) == (3000, [])
    assert len(series.since(0)[1]) == kept


def test_a_series_has_at_most_50_values_per_second() -> None:
    series = Series()
    for number, at_s in enumerate((1.0, 1.001, 1.019, 1.021)):
        assert series.is_due(at_s) is (number in (0, 3))
        series.add((number,), at_s)
    assert [it for _, it in series.since(0)[1]] == [(0,), (3,)]


def test_a_series_that_forgets_says_so_and_takes_an_earlier_time() -> None:
    series = Series()
    series.add((1,), 100.0)
    count, _ = series.since(0)
    series.forget()
    series.add((2,), 7.0)
    assert series.since(count) == (3, [(0, ()), (7.0, (2,))])


def test_the_state_has_what_diagnostics_say() -> None:
    levels = {"security": 1, "adaptation": 1, WORLD: 1, "session": 0}
    state = state_of(ROWS, levels, {"world_left": "1016x1016@30 jpeg"}, "50 %")
    (stream,) = state["streams"]
    assert stream == {
        "id": "world_left",
        "is_eye": False,
        "level": 1,
        "topic": WORLD,
        "rate_hz": 14.9,
        "expected_hz": 15,
        "latency_p50_ms": 12.5,
        "latency_p99_ms": None,
        "lost": 0,
        "state": "",
        "mode": "1016x1016@30 jpeg",
        "lowered": "15 Hz",
        "stages_ms": [10.5, 1.25, 0.75],
    }
    facts = {it["name"]: (it["text"], it["level"]) for it in state["facts"]}
    assert list(facts) == ["headset", "security", "clock", "link", "recording", "heat", "battery"]
    assert facts["headset"] == ("head, connected", 0)
    assert facts["security"] == ("insecure: no encryption", 1)
    assert facts["battery"] == ("50 %", 0)
    assert state["applied"] == {"world_left": "running, 1016x1016@30 jpeg"}
    assert [it["row"] for it in state["warnings"]] == ["adaptation"]
    assert state["losses"] == [
        {"topic": "/magic_leap2/battery", "recent": 0, "all": 4},
        {"topic": WORLD, "recent": 0, "all": 3},
    ]


def test_losses_of_the_last_10_s_are_told_from_those_before() -> None:
    def rows(gaps: int) -> dict[str, dict[str, str]]:
        return {WORLD: {**ROWS[WORLD], "gaps": str(gaps), "unpublished": "0"}}

    losses = RecentLosses()
    found = [
        losses.count(rows(gaps), at_s)[WORLD]
        for at_s, gaps in ((0, 5), (1, 7), (9, 7), (10, 8), (11, 8), (21, 8), (22, 1), (23, 3))
    ]
    # The count of a new session begins at 0 again.
    assert found == [0, 2, 2, 3, 1, 0, 0, 2]
    (world,) = state_of(rows(9), {}, {}, "", {WORLD: 1})["losses"]
    assert world == {"topic": WORLD, "recent": 1, "all": 9}


def test_subscriptions_of_apps_are_listed_and_are_no_topics_of_the_headset() -> None:
    counts = {"produced": "20", "sent": "9", "dropped.superseded": "4", "missed": "1"}
    dropped = {"dropped.queue_full": "2", "dropped.too_large": "3", "dropped.link_down": "1"}
    name = f"subscription {WORLD}"
    row = {"id": "1", "message_type": "sensor_msgs/msg/Image", **counts, **dropped}
    state = state_of(ROWS | {name: row}, {name: 1}, {}, "")
    assert state["subscriptions"] == [
        {
            "topic": WORLD,
            "type": "sensor_msgs/msg/Image",
            "sent": "9",
            "superseded": "4",
            "lost": "7",
        }
    ]
    before = state_of(ROWS, {}, {}, "")
    assert before["subscriptions"] == []
    assert (state["streams"], state["losses"]) == (before["streams"], before["losses"])
    assert name in [it["row"] for it in state["warnings"]]


def test_services_of_apps_are_listed_and_are_no_topics_of_the_headset() -> None:
    row = {"id": "1", "service_type": "T", "requests": "9", "responses": "4", "failures": "1"}
    state = state_of(ROWS | {"client /pause": row, "service /on": row}, {}, {}, "")
    counts = {"type": "T", "requests": "9", "responses": "4", "failures": "1"}
    assert state["calls"] == [
        {"service": "/pause", "by": "ROS", **counts},
        {"service": "/on", "by": "the app", **counts},
    ]
    before = state_of(ROWS, {}, {}, "")
    assert before["calls"] == []
    assert (state["streams"], state["losses"]) == (before["streams"], before["losses"])


def test_a_late_message_does_not_raise_the_rate_above_what_is_asked() -> None:
    row = {**ROWS[WORLD], "rate_hz": "34.0", "expected_hz": "30"}
    (stream,) = state_of(ROWS | {WORLD: row}, {}, {}, "")["streams"]
    assert (stream["rate_hz"], stream["expected_hz"]) == (30, 30)


def test_many_lowered_streams_are_counted_and_not_listed() -> None:
    row = {f"{it}.rate_hz": "15" for it in ("world_left", "world_right", "world_center")}
    row["message"] = "lowered for the link: world_left, world_right, world_center: 15 Hz"
    (warning,) = state_of({"adaptation": row}, {"adaptation": 1}, {}, "")["warnings"]
    assert warning["text"] == "lowered for the link: 3 streams, see below"


def test_without_ros_time_on_the_headset_there_are_no_stages() -> None:
    row = {key: it for key, it in ROWS[WORLD].items() if not key.startswith("window.")}
    (stream,) = state_of(ROWS | {WORLD: row}, {}, {}, "")["streams"]
    assert stream["stages_ms"] is None


def test_a_missing_permission_is_named_once_with_how_to_grant_it() -> None:
    camera, hands = "android.permission.CAMERA", "com.magicleap.permission.HAND_TRACKING"
    session = ROWS["session"] | {
        "state.world_left": "waiting: no permission",
        "missing.world_left": camera,
        "state.color": "waiting: no permission",
        "missing.color": camera,
        "state.hand_left": "waiting: no permission",
        "missing.hand_left": hands,
    }
    warnings = state_of(ROWS | {"session": session}, {}, {}, "")["warnings"]
    found = {it["row"]: it["text"] for it in warnings if "permission" in it["row"]}
    assert found == {
        f"permission {camera} is missing": "grant it with"
        " `ml2-receiver headset grant world_left color`",
        f"permission {hands} is missing": "grant it with `ml2-receiver headset grant hand_left`",
    }


def test_a_silent_stream_without_an_image_is_a_warning() -> None:
    session = ROWS["session"] | {
        "state.world_left": "silent: nothing has come for 3 s",
        "state.gyro_left": "silent: nothing has come for 5 s",
        "state.battery": "waiting: no message has come yet",
    }
    warnings = state_of(ROWS | {"session": session}, {}, {}, "")["warnings"]
    silent = [(it["row"], it["text"]) for it in warnings if it["text"].startswith("silent")]
    assert silent == [("gyro_left", "silent: nothing has come for 5 s")]


def test_a_stream_that_does_not_run_says_why() -> None:
    silent = {"session": {**ROWS["session"], "state.world_left": "silent: nothing has come"}}
    rows = ROWS | silent | {WORLD: {**ROWS[WORLD], "message": "silent: nothing has come"}}
    (stream,) = state_of(rows, {WORLD: 2}, {}, "50 %")["streams"]
    assert (stream["state"], stream["level"]) == ("silent: nothing has come", 2)


def test_the_prefix_is_that_of_the_topics() -> None:
    assert topic_prefix(ROWS) == "/magic_leap2"
    assert topic_prefix({"session": {}, "/tf": {"stream": "tf"}}) is None


def test_a_stream_that_is_not_requested_any_more_is_not_shown() -> None:
    session = {key: it for key, it in ROWS["session"].items() if key != "state.world_left"}
    state = state_of(ROWS | {"session": session}, {}, {}, "50 %")
    assert (state["streams"], state["applied"]) == ([], {})


def test_the_fields_of_a_type_are_its_numbers_at_any_depth() -> None:
    joy, pose = fields_of("sensor_msgs/msg/Joy"), fields_of("geometry_msgs/msg/PoseStamped")
    assert [*pose] == [f"pose.position.{it}" for it in "xyz"] + [
        f"pose.orientation.{it}" for it in "xyzw"
    ]
    assert {"axes[0]", "buttons[25]"} <= joy.keys()
    assert "orientation_covariance[8]" in fields_of("sensor_msgs/msg/Imu")
    assert "orientation_covariance[9]" not in fields_of("sensor_msgs/msg/Imu")
    for other in ("sensor_msgs/msg/Image", "std_msgs/msg/String", "some_msgs/msg/Unknown"):
        assert not fields_of(other)


def test_only_topics_with_names_of_ros_are_offered_for_plots() -> None:
    row = {"type": "sensor_msgs/msg/Joy"}
    rows = {"/a/joy": row, "joy": row, "/a b": row, "/a//b": row, "/image": {"type": "x"}}
    assert plottable_topics(rows) == {"/a/joy": "sensor_msgs/msg/Joy"}
    assert "/a/joy axes[0]" in topic_fields(plottable_topics(rows))

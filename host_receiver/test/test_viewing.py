"""The parts of `ml2-receiver view` that need neither ROS nor a browser."""

from __future__ import annotations

import json
import re
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from ml2_tools.viewing.access import Token, is_own_host, is_own_origin
from ml2_tools.viewing.controls import SERVICES, controls
from ml2_tools.viewing.page_files import HEADERS, page_files
from ml2_tools.viewing.plots import Series
from ml2_tools.viewing.preview import Preview, full_of, preview_of
from ml2_tools.viewing.requests import (
    Call,
    Change,
    Offer,
    Pair,
    Pixel,
    Play,
    RequestError,
    Seek,
    Seen,
    Show,
    Speed,
    parse_request,
)
from ml2_tools.viewing.state import image_streams, is_eye, state_of, topic_prefix

STREAMS = ("color", "world_left")
THREE = "/three.min.js"
CONTROLS = controls(with_eyes=False)
LIVE, RECORDED = Offer(CONTROLS, SERVICES, has_pairing=True), Offer(length_s=20.5)
WORLD = "/magic_leap2/world_left/image_raw"


def image(pixels: NDArray[Any], encoding: str) -> Any:
    height, width = pixels.shape
    step = width * pixels.itemsize
    data = pixels.tobytes()
    return SimpleNamespace(
        height=height, width=width, encoding=encoding, is_bigendian=0, step=step, data=data
    )


def jpeg(pixels: NDArray[Any], quality: int) -> Any:
    data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
    return SimpleNamespace(format="rgb8; jpeg compressed bgr8", data=data)


def decoded(preview: Preview) -> NDArray[Any]:
    return np.asarray(cv2.imdecode(np.frombuffer(preview.jpeg, np.uint8), cv2.IMREAD_UNCHANGED))


def test_the_longer_side_of_a_grey_preview_is_640_pixels() -> None:
    ramp = np.tile(np.linspace(0, 255, 1280, dtype=np.uint8), (960, 1))
    found = decoded(preview_of(image(ramp, "mono8"), is_distance=False))
    assert found.shape == (480, 640)
    assert found[200, [5, 635]] == pytest.approx([2, 253], abs=4)


def test_a_small_jpeg_stays_as_it_is() -> None:
    message = jpeg(np.full((1080, 1920, 3), 90, np.uint8), 80)
    assert preview_of(message, is_distance=False) == Preview(message.data, 0)


def test_a_large_jpeg_is_made_smaller_but_stays_as_it_is_in_full_size() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (1080, 1920, 3), np.uint8)
    message = jpeg(noise, 95)
    found = preview_of(message, is_distance=False)
    assert decoded(found).shape == (360, 640, 3)
    assert full_of(message, is_distance=False) == Preview(message.data, 0)


def test_other_images_are_encoded_in_full_size() -> None:
    ramp = np.tile(np.linspace(0, 255, 1280, dtype=np.uint8), (960, 1))
    found = decoded(full_of(image(ramp, "mono8"), is_distance=False))
    assert np.abs(found.astype(int) - ramp).max() <= 3
    metres = image(np.full((960, 1280), 0.9, np.float32), "32FC1")
    depth = full_of(metres, is_distance=True)
    assert (decoded(depth).shape, depth.far_m) == ((960, 1280, 3), 1)


@pytest.mark.parametrize(
    ("metres", "far_m"), [(0.1, 0.5), (0.9, 1), (1.2, 2), (2.4, 5), (5.1, 10), (43, 50)]
)
def test_the_scale_of_distances_ends_at_a_step(metres: float, far_m: float) -> None:
    flat = image(np.full((4, 4), metres, np.float32), "32FC1")
    assert preview_of(flat, is_distance=True).far_m == pytest.approx(far_m)


def test_near_is_blue_far_is_red_and_invalid_is_black() -> None:
    metres = np.repeat(np.array([[0.5, 3.9, np.nan]], np.float32), 32, axis=1).repeat(16, axis=0)
    found = decoded(preview_of(image(metres, "32FC1"), is_distance=True))
    near, far, invalid = (found[8, it].astype(int) for it in (16, 48, 80))
    assert near[0] > 150 > near[2]
    assert far[2] > 150 > far[0]
    assert invalid == pytest.approx([0, 0, 0], abs=8)


def test_an_image_without_any_distance_is_black() -> None:
    nothing = image(np.full((16, 16), np.nan, np.float32), "32FC1")
    assert decoded(preview_of(nothing, is_distance=True)).max() < 8


@pytest.mark.parametrize(
    "message",
    [
        SimpleNamespace(format="jpeg", data=b"\xff\xd8 no JPEG"),
        SimpleNamespace(format="h264", data=b"0000"),
        SimpleNamespace(format="jpeg", data=jpeg(np.zeros((9, 9, 3), np.uint8), 80).data[:30]),
    ],
)
def test_a_broken_image_is_refused(message: Any) -> None:
    with pytest.raises(ValueError, match="expected"):
        preview_of(message, is_distance=False)


@pytest.mark.parametrize("host", ["127.0.0.1:8700", "localhost:1", "localhost", "[::1]:8700"])
def test_hosts_of_this_machine(host: str) -> None:
    assert is_own_host([host])
    assert is_own_origin([f"http://{host}"], [host])


@pytest.mark.parametrize(
    "hosts",
    [[], ["evil.example"], ["localhost.evil.example"], ["127.0.0.1", "evil.example"], ["0:80"]],
)
def test_other_hosts_are_refused(hosts: list[str]) -> None:
    assert not is_own_host(hosts)
    assert not is_own_origin([f"http://{it}" for it in hosts], hosts)


@pytest.mark.parametrize("origin", ["http://localhost:2", "https://localhost:1", "null"])
def test_other_origins_are_refused(origin: str) -> None:
    assert not is_own_origin([origin], ["localhost:1"])


def test_only_the_token_opens() -> None:
    token = Token()
    assert token.opens(json.dumps({"token": token.text}))
    assert token.text != Token().text
    for wrong in ("", "[", "[" * 4000, "1", '"token"', '{"token": 1}', '{"token": "\\ud800"}'):
        assert not token.opens(wrong)
    assert not token.opens(json.dumps({"token": token.text[:-1]}))
    assert not token.opens(b"\xff")


def test_requests_are_read() -> None:
    assert parse_request('{"show": ["color"]}', STREAMS, LIVE) == Show(frozenset({"color"}))
    assert parse_request('{"show": []}', STREAMS, LIVE) == Show(frozenset())
    assert parse_request('{"seen": "state"}', STREAMS, LIVE) == Seen("state")
    assert parse_request('{"call": "stop"}', STREAMS, LIVE) == Call("stop")
    assert parse_request('{"pair": true}', STREAMS, LIVE) == Pair(True)
    pixel = '{"pixel": "color", "at": [1, 0]}'
    assert parse_request(pixel, STREAMS, LIVE) == Pixel("color", 1, 0)
    values: dict[str, Any] = {
        "stream": 1,
        "mode": "544x480@5",
        "format": "depth16",
        "enabled": True,
    }
    change = json.dumps({"set": "depth_center", "to": values})
    assert parse_request(change, STREAMS, LIVE) == Change("depth_center", values)


def test_requests_to_a_recording_are_read() -> None:
    assert parse_request('{"show": ["color"]}', STREAMS, RECORDED) == Show(frozenset({"color"}))
    assert parse_request('{"play": false}', STREAMS, RECORDED) == Play(False)
    assert parse_request('{"seek": 20.5}', STREAMS, RECORDED) == Seek(20.5)
    assert parse_request('{"seek": 0}', STREAMS, RECORDED) == Seek(0)
    assert parse_request('{"speed": 0.25}', STREAMS, RECORDED) == Speed(0.25)


@pytest.mark.parametrize(
    "message",
    [
        '{"play": 1}',
        '{"pair": true}',
        '{"seek": 20.6}',
        '{"seek": -0.1}',
        '{"seek": NaN}',
        '{"seek": 1e999}',
        '{"seek": true}',
        '{"seek": "1"}',
        '{"speed": 4.1}',
        '{"speed": 0}',
        '{"speed": true}',
        '{"seek": 1, "play": true}',
        '{"call": "stop"}',
        '{"set": "battery", "to": {"enabled": true}}',
    ],
)
def test_a_recording_takes_no_other_requests(message: str) -> None:
    with pytest.raises(RequestError):
        parse_request(message, STREAMS, RECORDED)


@pytest.mark.parametrize(
    "message",
    [
        "",
        "[" * 4000,
        "null",
        "{}",
        b'{"show": []}',
        '{"show": "color"}',
        '{"show": ["eye_nasal_left"]}',
        '{"show": [["color"]]}',
        '{"show": [], "seen": "color"}',
        '{"seen": 1}',
        '{"set": {"general.link": 1}}',
        '{"set": "general", "to": {"link": "fast"}}',
        '{"set": "general", "to": {"link": "-1"}}',
        '{"set": "general", "to": {"link": true}}',
        '{"set": "general", "to": {"topic_name": "/x"}}',
        '{"set": "world_left", "to": {"quality": 0}}',
        '{"set": "world_left", "to": {"quality": 80.5}}',
        '{"set": "world_left", "to": {"quality": "80"}}',
        '{"set": "depth_center", "to": {"quality": 80}}',
        '{"set": "battery", "to": {}}',
        '{"set": "battery", "to": {"enabled": 1}}',
        '{"set": "battery", "to": {"enabled": [true]}}',
        '{"set": "battery", "to": {"enabled": true}, "call": "stop"}',
        '{"set": "battery", "to": {"mode": "1016x1016@30"}}',
        '{"set": "depth_center", "to": {"stream": true}}',
        '{"set": "depth_center", "to": {"stream": 1.0}}',
        '{"set": "depth_center", "to": {"mode": "1016x1016@30"}}',
        '{"set": "depth_center", "to": {"calibration": "/etc/passwd"}}',
        '{"set": "eye_nasal_left", "to": {"enabled": true}}',
        '{"set": ["battery"], "to": {"enabled": true}}',
        '{"call": "reload"}',
        '{"pixel": "color"}',
        '{"pixel": "color", "at": [1]}',
        '{"pixel": "color", "at": [1.5, 0]}',
        '{"pixel": "eye_nasal_left", "at": [0, 0]}',
        '{"call": ["stop"]}',
        '{"pair": 1}',
        '{"play": true}',
        '{"seek": 0}',
        '{"speed": 1}',
    ],
)
def test_other_requests_are_refused(message: str | bytes) -> None:
    with pytest.raises(RequestError):
        parse_request(message, STREAMS, LIVE)


def test_each_mode_of_a_control_may_be_asked_for() -> None:
    asked = [
        (control, {"stream": stream, "mode": mode})
        for control in controls(with_eyes=True).values()
        for stream, mode in control.modes
    ]
    assert len(asked) > 40
    assert all(control.takes(values) for control, values in asked)


@pytest.mark.parametrize(
    ("section", "values"),
    [
        ("world_left", {"quality": 1}),
        ("world_left", {"quality": 100, "format": "jpeg"}),
        ("general", {"link": "auto"}),
        ("general", {"link": "fixed"}),
        ("general", {"link": "99.5"}),
    ],
)
def test_quality_and_link_may_be_asked_for(section: str, values: dict[str, int | str]) -> None:
    message = json.dumps({"set": section, "to": values})
    assert parse_request(message, STREAMS, LIVE) == Change(section, values)


def test_eye_cameras_are_steered_on_request_only() -> None:
    eyes = {"eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right"}
    assert controls(with_eyes=True).keys() - CONTROLS.keys() == eyes


def test_the_buttons_of_the_page_are_the_services() -> None:
    _, html = page_files()["/"]
    assert set(re.findall(r'data-call="(\w+)"', html.decode())) == SERVICES


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
        "lost": 3,
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
    assert [it["row"] for it in state["warnings"]] == ["adaptation", "lost messages"]
    assert state["warnings"][-1]["text"] == "/magic_leap2/battery 4"


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


def test_a_stream_that_is_not_requested_any_more_is_not_shown() -> None:
    session = {key: it for key, it in ROWS["session"].items() if key != "state.world_left"}
    state = state_of(ROWS | {"session": session}, {}, {}, "50 %")
    assert (state["streams"], state["applied"]) == ([], {})


def test_the_prefix_is_that_of_the_topics() -> None:
    assert topic_prefix(ROWS) == "/magic_leap2"
    assert topic_prefix({"session": {}, "/tf": {"stream": "tf"}}) is None


def test_eye_cameras_are_offered_on_request_only() -> None:
    eyes = {"eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right"}
    assert {it for it in image_streams(with_eyes=True) if is_eye(it)} == eyes
    assert set(image_streams(with_eyes=False)) == set(image_streams(with_eyes=True)) - eyes


def test_the_page_refers_to_its_own_files_only() -> None:
    files = {path: content.decode() for path, (_, content) in page_files().items()}
    assert {"/", "/main.js", "/style.css"} <= files.keys()
    # The name of a namespace is no address that is opened.
    bundle = files[THREE].replace("http://www.w3.org/1999/xhtml", "")
    own = {path: text for path, text in files.items() if path != THREE}
    for path, text in own.items():
        found = re.findall(r"""(?:src|href|from|import)\s*[=(]?\s*["']([^"']+)["']""", text)
        assert {f"/{it.removeprefix('./')}" for it in found} <= files.keys(), path
    for path, text in (own | {THREE: bundle}).items():
        assert not re.search(r"url\(|@import|\bhttps?:", text), path
    addresses = [it for text in own.values() for it in re.findall(r"\w+://[^/`\"']*", text)]
    assert addresses == ["ws://${location.host}"]


def test_the_licence_of_three_is_beside_it() -> None:
    _, licence = page_files()["/three.LICENSE.txt"]
    assert licence.startswith(b"The MIT License\n\nCopyright")
    assert b"SPDX-License-Identifier: MIT" in page_files()[THREE][1]


def test_the_page_has_no_code_or_style_in_its_html() -> None:
    _, html = page_files()["/"]
    assert not re.search(rb"<style|style=|\son\w+=|<script(?![^>]*\ssrc=)", html)


def test_the_policy_allows_the_own_server_only() -> None:
    policy = dict(it.split(maxsplit=1) for it in HEADERS["Content-Security-Policy"].split("; "))
    assert policy.pop("default-src") == "'none'"
    assert set(policy.values()) <= {"'self'", "'none'"}

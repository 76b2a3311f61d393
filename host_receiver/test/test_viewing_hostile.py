"""The page of `ml2-receiver view` goes on after malformed messages and reports."""

import json
import math
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import bag_scene
from compressed_images import with_scans
from ros_messages import compressed_image, header, message, payload
from view_scene import (
    COMPRESSED_ROWS,
    COUNTS,
    DEPTH_RVL,
    IMAGE,
    ROWS,
    WORLD,
    WORLD_JPEG,
    Page,
    serving,
)
from viewing_browser import Browser, Picture

pytest.importorskip("websockets", reason="websockets is not installed")

from ml2_receiver.json_text import json_text
from ml2_tools.viewing import newest_image
from ml2_tools.viewing.state import state_of
from ml2_tools.viewing.view import View

LENS_FRAME = header("world_left_optical_frame", 1)
NOTHING = np.zeros(0, np.uint8)
JPEG = cv2.imencode(".jpg", np.full((8, 8), 100, np.uint8))[1].tobytes()


def plain(height: int, width: int, encoding: str, step: int, data: bytes, is_big: int = 0) -> bytes:
    values = np.frombuffer(data, np.uint8)
    return payload(IMAGE, LENS_FRAME, height, width, encoding, is_big, step, values)


def floats(*values: float) -> bytes:
    return np.array(values, np.float32).tobytes()


PLAIN = {
    "no width": plain(4, 0, "mono8", 4, bytes(16)),
    "no height": plain(0, 4, "mono8", 4, b""),
    "no size": plain(0, 0, "mono8", 0, b""),
    "no width of floats": plain(4, 0, "32FC1", 4, bytes(16)),
    "no step": plain(4, 4, "mono8", 0, bytes(16)),
    "short step": plain(4, 4, "mono8", 3, bytes(12)),
    "no data": plain(4, 4, "mono8", 4, b""),
    "short data": plain(480, 640, "mono8", 640, bytes(100)),
    "more data": plain(4, 4, "mono8", 4, bytes(17)),
    "a line of pixels": plain(1, 100_000, "mono8", 100_000, bytes(100_000)),
    "the largest size": plain(2**32 - 1, 2**32 - 1, "mono8", 2**32 - 1, b"1"),
    "no encoding": plain(4, 4, "", 4, bytes(16)),
    "colours": plain(4, 4, "bgr8", 12, bytes(48)),
    "a long encoding": plain(4, 4, "\x1b]52;c;aGk=\x07" * 9999, 4, bytes(16)),
    "big endian": plain(2, 2, "32FC1", 8, bytes(16), is_big=1),
    "no image": b"\0\1\0\0" + b"\xff" * 40,
    "nothing": b"",
}
PACKED = {
    "no data": compressed_image(LENS_FRAME, "mono8; jpeg compressed mono8", NOTHING),
    "no format": compressed_image(LENS_FRAME, "", NOTHING),
    "a long format": compressed_image(LENS_FRAME, "\x1b[31mjpeg" * 9999, b"\xff\xd8"),
    "depth as grey": compressed_image(LENS_FRAME, "16UC1; compressedDepth png", b"x"),
    "too many scans": compressed_image(LENS_FRAME, "jpeg", with_scans(JPEG, 1000)),
    "a jpeg without scans": compressed_image(LENS_FRAME, "jpeg", with_scans(JPEG, 0)),
    "a png": compressed_image(
        LENS_FRAME, "jpeg", cv2.imencode(".png", np.zeros((4, 4), np.uint8))[1].ravel()
    ),
}


def strict(text: str) -> Any:
    """Reads JSON as browsers do."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


def reason_for(browser: Browser, stream: str) -> str:
    """The next reason why an image cannot be shown."""
    while True:
        found = browser.next()
        if isinstance(found, dict) and found["type"] == "image" and found["reason"]:
            assert found["stream"] == stream
            return str(found["reason"])


@pytest.fixture
def page() -> Iterator[Page]:
    with serving(ROWS) as page:
        yield page


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        *((it, "full world_left") for it in PLAIN),
        # A line of pixels can be shown as a small image.
        *((it, "world_left") for it in PLAIN if it != "a line of pixels"),
    ],
)
def test_an_image_that_is_none_is_said_and_the_next_one_is_shown(
    kind: str, name: str, page: Page
) -> None:
    with page.browser() as browser:
        browser.say(show=[name, "scene", "cloud"])
        page.source.bring(WORLD, PLAIN[kind])
        reason = reason_for(browser, name)
        assert reason.isprintable()
        assert len(reason) <= 2000
        page.source.bring(WORLD, bag_scene.image(1))
        assert browser.picture().pixels.shape == (48, 64)


@pytest.mark.parametrize("kind", PACKED)
@pytest.mark.parametrize("prefix", ["", "full "])
def test_a_compressed_image_that_is_none_is_said_and_the_next_one_is_shown(
    kind: str, prefix: str
) -> None:
    with serving(COMPRESSED_ROWS) as page, page.browser() as browser:
        for stream, topic, good in (
            ("world_left", WORLD_JPEG, bag_scene.jpeg(1)),
            ("depth", DEPTH_RVL, bag_scene.depth(1)),
        ):
            name = prefix + stream
            browser.say(show=[name])
            page.source.bring(topic, PACKED[kind])
            reason = reason_for(browser, name)
            assert reason.isprintable()
            assert len(reason) <= 2000
            page.source.bring(topic, good)
            while browser.picture().stream != name:
                pass


def test_distances_beyond_all_rooms_are_shown() -> None:
    topic = "/p/depth/image_raw"
    rows = {"session": ROWS["session"], topic: {"stream": "depth", "type": IMAGE, **COUNTS}}
    with serving(rows) as page, page.browser() as browser:
        browser.say(show=["depth", "full depth"])
        data = floats(3.3e38, -3.3e38, math.inf, math.nan)
        page.source.bring(topic, plain(2, 2, "32FC1", 8, data), count=2)
        assert {browser.picture().stream for _ in range(2)} == {"depth", "full depth"}


HOSTILE_ROWS: dict[str, dict[str, dict[str, str]]] = {
    "a topic without stream": {"/x": {"type": IMAGE, **COUNTS}},
    "a topic without counts": {"/x": {"type": IMAGE, "stream": "world_right"}},
    "a topic of an unknown type": {
        "/magic_leap2/world_right/image_raw": {"type": "a/msg/B", "stream": "world_right", **COUNTS}
    },
    "a topic of another type": {
        "/magic_leap2/battery": {"type": IMAGE, "stream": "battery", **COUNTS}
    },
    "a topic of no type": {"/x": {"type": "", "stream": "", **COUNTS}},
    "no numbers": {
        WORLD: dict(ROWS[WORLD])
        | {"rate_hz": "nan", "latency_p50_ms": "inf", "latency_p99_ms": "-inf", "gaps": "nan"}
        | {"expected_hz": "9" * 400, "mbit_per_s": "x", "dropped.late": "1e999", "subscribers": ""}
        | {f"window.{it}_ms": "nan" for it in ("capture_to_sent", "sent_to_received")}
        | {"window.received_to_published_ms": "inf"}
    },
    "counts that are no numbers": {WORLD: dict(ROWS[WORLD]) | {"gaps": "x", "unpublished": "-"}},
    "a recording without numbers": {"recording": {"state": "nan", "file_bytes": "nan"}},
    "a recording of nothing": {"recording": {}},
    "a clock without numbers": {"clock": {"uncertainty_ns": "nan"}},
    "a clock of words": {"clock": {"uncertainty_ns": "soon"}},
    "a lowered stream": {"adaptation": {"world_left.quality": "\x1b[31m", ".rate_hz": "nan"}},
    "a session of nothing": {"other": {}},
}


@pytest.mark.parametrize("kind", HOSTILE_ROWS)
def test_the_state_goes_on_whatever_is_reported(kind: str, page: Page) -> None:
    with page.browser() as browser:
        browser.say(show=["world_left", "scene"])
        page.source.report(ROWS | HOSTILE_ROWS[kind])
        page.source.bring(WORLD, bag_scene.image(1))
        assert browser.picture().stream == "world_left"
        found = strict(page.view.state[1])
        assert "problem" not in found
        assert [it["id"] for it in found["streams"]] == ["world_left"]
        page.source.report(ROWS)
        assert page.view.state[0] >= 3


def test_a_topic_of_another_type_is_named_and_not_read(page: Page) -> None:
    page.source.report(ROWS | HOSTILE_ROWS["a topic of an unknown type"])
    with page.browser() as browser:
        browser.say(show=["world_left", "world_right"])
        page.source.bring(WORLD, bag_scene.image(1))
        browser.picture()
        assert [it.topic for it in page.source.subscriptions if "world_right" in it.topic] == []
    (warning,) = strict(page.view.state[1])["warnings"]
    assert warning["row"] == "/magic_leap2/world_right/image_raw"
    assert warning["text"] == f"expected {IMAGE}, found a/msg/B"


VALUES = st.sampled_from(["", "nan", "-inf", "1e999", "-1", "3", "2.5", "9" * 500, "\x1b[", "x"])
TOPIC_KEYS = ["type", "stream", "gaps", "unpublished", "dropped.x", "rate_hz", "message", "needs"]
OTHER_KEYS = ["state", "file_bytes", "duration_s", "state.world_left", "missing.world_left"]
WINDOW_KEYS = ["window.capture_to_sent_ms", "subscribers", "latency_p99_ms", "world_left.quality"]
KEYS = st.sampled_from([*TOPIC_KEYS, *OTHER_KEYS, *WINDOW_KEYS])
TYPED = st.sampled_from([{}, {"type": IMAGE}, {"type": "a/msg/B"}, dict(ROWS[WORLD])])
NAMES = st.sampled_from(
    ["session", "clock", "recording", "adaptation", "link", "security", WORLD, "/x", ""]
)


@given(st.dictionaries(NAMES, st.tuples(TYPED, st.dictionaries(KEYS, VALUES))))
def test_the_state_of_any_report_is_json(given_rows: dict[str, Any]) -> None:
    rows = {name: typed | values for name, (typed, values) in given_rows.items()}
    state = state_of(rows, dict.fromkeys(rows, 1), {}, "")
    assert strict(json_text(state))["type"] == "state"


@pytest.mark.parametrize(
    "value", [math.nan, {"a": [math.inf, 1]}, (1, -math.inf), {"b": {"c": np.float64("nan")}}]
)
def test_json_has_null_for_what_is_no_number(value: Any) -> None:
    assert "null" in json_text(value)
    strict(json_text(value, indent=2))


def camera_info(k: float, width: int = 64, height: int = 48, model: str = "plumb_bob") -> bytes:
    matrix = np.array([k, 0, 1, 0, k, 1, 0, 0, 1.0])
    projection = np.array([1.0, 0, 1, 0, 0, 1.0, 1, 0, 0, 0, 1.0, 0])
    roi = message("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
    lens = np.zeros(5 if model == "plumb_bob" else 4)
    fields = (height, width, model, lens, matrix, np.eye(3).ravel(), projection, 0, 0, roi)
    return payload("sensor_msgs/msg/CameraInfo", LENS_FRAME, *fields)


INFOS = {
    "zeros": camera_info(0, 0, 0),
    "no focal length": camera_info(0),
    "no number": camera_info(math.nan),
    "an endless view": camera_info(5e-324),
    "an endless view of a fisheye": camera_info(5e-324, model="equidistant"),
    "nothing": b"",
}


@pytest.mark.parametrize("kind", INFOS)
def test_a_camera_info_that_is_none_stops_nothing(kind: str) -> None:
    info = "/magic_leap2/world_left/camera_info"
    type = "sensor_msgs/msg/CameraInfo"
    rows = ROWS | {info: {"stream": "world_left", "type": type, **COUNTS}}
    with serving(rows) as page, page.browser() as browser:
        browser.say(show=["world_left", "scene", "cloud"])
        page.source.bring(info, INFOS[kind])
        tf = payload("tf2_msgs/msg/TFMessage", [moved("world_left_optical_frame")])
        page.source.bring("/tf", tf)
        assert browser.text("scene")["cameras"] == {}
        page.source.bring(WORLD, bag_scene.image(1))
        assert browser.picture().stream == "world_left"


def moved(child: str) -> Any:
    vector = message("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
    turn = message("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    transform = message("geometry_msgs/msg/Transform", vector, turn)
    return message(
        "geometry_msgs/msg/TransformStamped", header("magicleap_world", 1), child, transform
    )


def broken(*_: Any, **__: Any) -> Any:
    raise RuntimeError("nobody foresaw \x1b[31mthis" + "." * 500)


def test_a_sender_that_fails_closes_the_connection_and_the_page_comes_again(
    page: Page, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with page.browser() as browser, monkeypatch.context() as patched:
        browser.say(show=["world_left"])
        patched.setattr(newest_image, "preview_of", broken)
        page.source.bring(WORLD, bag_scene.image(1))
        code, reason = browser.end()
    assert code == 1011
    assert "nobody foresaw" in reason
    assert reason.isprintable()
    with page.browser() as browser:
        browser.say(show=["world_left"])
        page.source.bring(WORLD, bag_scene.image(2))
        assert browser.picture().stream == "world_left"
    assert "nobody foresaw" in capsys.readouterr().err


def test_a_reader_that_fails_closes_the_connection(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    with page.browser() as browser, monkeypatch.context() as patched:
        patched.setattr(View, "watch", broken)
        browser.say(show=["world_left"])
        code, reason = browser.end()
    assert (code, "nobody foresaw" in reason) == (1011, True)
    with page.browser() as browser:
        assert browser.text("hello")


def test_a_message_that_fails_is_left_out_and_counted(
    page: Page, monkeypatch: pytest.MonkeyPatch
) -> None:
    with page.browser() as browser:
        browser.say(show=["world_left"])
        browser.text("state")
        with monkeypatch.context() as patched:
            patched.setattr(newest_image.NewestImage, "take", broken)
            page.source.bring(WORLD, bag_scene.image(1))
        page.source.bring(WORLD, bag_scene.image(2))
        assert browser.picture().stream == "world_left"
        page.source.report(ROWS)
        (warning,) = strict(page.view.state[1])["warnings"]
    assert warning["row"] == "left out"
    assert warning["text"].startswith(f"1 times a message of {WORLD}: RuntimeError")


def test_a_pixel_is_at_numbers(page: Page) -> None:
    with page.browser() as browser:
        browser.say(show=["full world_left"])
        page.source.bring(WORLD, bag_scene.image(1))
        assert isinstance(browser.picture(), Picture)
        browser.say(pixel="world_left", at=[True, 3])
        assert browser.end()[0] == 1008

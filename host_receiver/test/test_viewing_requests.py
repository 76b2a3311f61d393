"""The requests of browsers to `ml2-receiver view`: legal ones, and hostile ones."""

import json
import re
from typing import Any

import pytest

from ml2_receiver.table.reader import load_table
from ml2_tools.viewing.page_files import page_files
from ml2_tools.viewing.products_beside import PRODUCTS
from ml2_tools.viewing.requests import (
    AllowedRequests,
    Call,
    Change,
    Pair,
    Pixel,
    Play,
    RequestError,
    Seek,
    Seen,
    Show,
    Snapshot,
    Speed,
    parse_request,
)
from ml2_tools.viewing.section_forms import SERVICES, section_forms
from ml2_tools.viewing.state import image_streams

STREAMS = ("color", "world_left")
FORMS = section_forms(with_eyes=False)
LIVE = AllowedRequests(FORMS, SERVICES, has_pairing=True)
RECORDED = AllowedRequests(length_s=20.5)


def test_requests_are_read() -> None:
    assert parse_request('{"show": ["color"]}', STREAMS, LIVE) == Show(frozenset({"color"}))
    assert parse_request('{"show": []}', STREAMS, LIVE) == Show(frozenset())
    assert parse_request('{"seen": "state"}', STREAMS, LIVE) == Seen("state")
    for offer in (LIVE, RECORDED):
        assert parse_request('{"snapshot": true}', STREAMS, offer) == Snapshot()
    assert parse_request('{"call": "stop"}', STREAMS, LIVE) == Call("stop")
    named = '{"call": "save_config", "keys": ["world_left.format", "depth_center.mode"]}'
    keys = ("world_left.format", "depth_center.mode")
    assert parse_request(named, STREAMS, LIVE) == Call("save_config", keys)
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
        '{"call": "stop", "keys": ["battery.enabled"]}',
        '{"call": "save_config", "keys": "battery.enabled"}',
        '{"call": "save_config", "keys": [1]}',
        '{"call": "save_config", "keys": ["general.eye_cameras"]}',
        '{"call": "save_config", "keys": ["eye_nasal_left.enabled"]}',
        '{"call": "save_config", "keys": ["battery.enabled tf.layout"]}',
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


def test_each_mode_of_a_form_may_be_asked_for() -> None:
    asked = [
        (form, {"stream": stream, "mode": mode})
        for form in section_forms(with_eyes=True).values()
        for stream, mode in form.modes
    ]
    assert len(asked) > 40
    assert all(form.takes(values) for form, values in asked)


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
    assert section_forms(with_eyes=True).keys() - FORMS.keys() == eyes


def test_the_buttons_of_the_page_are_the_services() -> None:
    _, script = page_files()["/actions.js"]
    labels = script.decode().partition("const LABELS = {")[2].partition("}")[0]
    assert set(re.findall(r"(\w+): ", labels)) == SERVICES | PRODUCTS


def test_eye_cameras_are_offered_on_request_only() -> None:
    eyes = {"eye_nasal_left", "eye_nasal_right", "eye_temple_left", "eye_temple_right"}
    assert {it for it in image_streams(with_eyes=True) if load_table().shows_eyes(it)} == eyes
    assert set(image_streams(with_eyes=False)) == set(image_streams(with_eyes=True)) - eyes

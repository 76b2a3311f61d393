"""The newest image of a stream, as browsers get it."""

from __future__ import annotations

import json
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import count

import pytest

import bag_scene
from ml2_tools.viewing import newest_image
from ml2_tools.viewing.newest_image import NewestImage
from ml2_tools.viewing.preview import preview_of

TYPE = "sensor_msgs/msg/Image"


def test_an_image_is_encoded_once_for_all_browsers(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = count()
    monkeypatch.setattr(
        newest_image, "preview_of", lambda *it, **named: (next(calls), preview_of(*it, **named))[1]
    )
    image = NewestImage("world_left")
    assert image.take(TYPE, bag_scene.image(1))
    with ThreadPoolExecutor(4) as browsers:
        found = list(browsers.map(lambda _: image.encoded(), range(20)))
    assert next(calls) == 1
    assert {number for number, _ in found} == {1}
    assert len({id(message) for _, message in found}) == 1


@pytest.mark.parametrize(("rate_hz", "shown_hz"), [(10, 10), (15, 15), (30, 15), (60, 15)])
def test_at_most_15_images_per_second_are_encoded_and_the_last_one_is(
    rate_hz: int, shown_hz: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    image = NewestImage("world_left")
    payload = bag_scene.image(1)
    shown = set()
    for number in range(10 * rate_hz):
        now_s = 100 + number / rate_hz
        monkeypatch.setattr(time, "monotonic", lambda now_s=now_s: now_s)
        image.take(TYPE, payload)
        shown.add(image.encoded()[0])
    assert len(shown) == pytest.approx(10 * shown_hz, abs=2)
    monkeypatch.setattr(time, "monotonic", lambda: 111.0)
    assert image.encoded()[0] == 10 * rate_hz


def test_a_forgotten_image_is_gone_for_browsers_too() -> None:
    image = NewestImage("world_left")
    image.take(TYPE, bag_scene.image(1))
    image.forget()
    number, message = image.encoded()
    assert (number, json.loads(message)["reason"]) == (2, "")


@pytest.mark.parametrize("payload", [b"", b"\0\1\0\0" + b"\xff" * 40, bag_scene.image(1)[:-100]])
def test_an_image_that_cannot_be_read_is_said_in_words(payload: bytes) -> None:
    image = NewestImage("world_left")
    image.take(TYPE, payload)
    number, message = image.encoded()
    found = json.loads(message)
    assert (number, found["type"], found["stream"]) == (1, "image", "world_left")
    assert found["reason"]

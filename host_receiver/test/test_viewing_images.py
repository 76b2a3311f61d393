"""The newest image of a stream, as browsers and snapshots get it."""

import json
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import bag_scene
from ml2_tools.viewing import newest_image, snapshot
from ml2_tools.viewing.full_image import FullImage
from ml2_tools.viewing.newest_image import NewestImage
from ml2_tools.viewing.preview import preview_of

TYPE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


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


def test_each_image_in_full_size_is_encoded_under_a_name_of_its_own() -> None:
    image = FullImage("world_left")
    for number in range(1, 4):
        assert image.take(TYPE, bag_scene.image(number))
        found, message = image.encoded()
        assert (found, message[:16]) == (number, b"\x0ffull world_left")


def test_pixels_are_those_of_the_original_image() -> None:
    grey, depth, colour = FullImage("world_left"), FullImage("depth"), FullImage("color")
    grey.take(TYPE, bag_scene.image(1))
    depth.take(COMPRESSED, bag_scene.depth(1))
    assert grey.pixel(63, 47) == [bag_scene.pixels(1)[47, 63]]
    metres = bag_scene.millimetres(1) / 1000
    assert depth.pixel(5, 2) == [pytest.approx(metres[2, 5])]
    blue = np.full((16, 16, 3), (250, 100, 10), np.uint8)
    colour.take(COMPRESSED, bag_scene.colour_jpeg(blue))
    assert colour.pixel(8, 8) == [pytest.approx(it, abs=3) for it in (10, 100, 250)]
    # A new image has new pixels.
    grey.take(TYPE, bag_scene.image(2))
    assert grey.pixel(63, 47) == [bag_scene.pixels(2)[47, 63]]


def test_what_has_no_value_is_said() -> None:
    image, depth = FullImage("world_left"), FullImage("depth")
    assert image.pixel(0, 0) == []
    image.take(TYPE, bag_scene.image(1))
    for column, row in ((64, 0), (0, 48), (-1, 0), (0, -1), (10**30, 0)):
        assert image.pixel(column, row) == []
    image.take(TYPE, b"no image")
    assert image.pixel(0, 0) == []
    invalid = np.zeros((4, 4), np.uint16)
    depth.take(COMPRESSED, bag_scene.depth_of(invalid))
    assert depth.pixel(0, 0) == [None]


@pytest.mark.parametrize("payload", [b"", b"\0\1\0\0" + b"\xff" * 40, bag_scene.image(1)[:-100]])
def test_an_image_that_cannot_be_read_is_said_in_words(payload: bytes) -> None:
    image = NewestImage("world_left")
    image.take(TYPE, payload)
    number, message = image.encoded()
    found = json.loads(message)
    assert (number, found["type"], found["stream"]) == (1, "image", "world_left")
    assert found["reason"]


class Images:
    """Has a new image each time, as where images come faster than the poses of their captures."""

    def __init__(self) -> None:
        self._numbers = count(1)

    @property
    def newest(self) -> tuple[int, str, bytes]:
        number = next(self._numbers)
        return number, TYPE, bag_scene.image(number)


class LatePoses:
    """Knows the pose of a capture only when it is asked for it again."""

    def __init__(self) -> None:
        self._asked = set[int]()

    def pose_at(self, _: str, stamp_ns: int) -> Any:
        is_known = stamp_ns in self._asked
        self._asked.add(stamp_ns)
        return "pose" if is_known else None

    def lens(self, _: str) -> str:
        return "lens"


def test_an_image_is_kept_until_its_pose_has_come(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(snapshot, "_POLL_S", 0.001)
    view: Any = SimpleNamespace(images={"depth": Images()}, scene=LatePoses())
    assert snapshot._newest(view, ["depth"])["depth"][0] == 1

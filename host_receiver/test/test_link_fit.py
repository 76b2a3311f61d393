"""The change of a configuration with which its images fit a link."""

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ml2_receiver.configuration.config import Config
from ml2_receiver.configuration.forecast import images_mbit_per_s
from ml2_receiver.configuration.link_fit import (
    bound_mbit_per_s,
    fitting_change,
    link_in_words,
)
from ml2_receiver.configuration.settings import Settings
from test_forecast import config

RAW: dict[str, dict[str, Any]] = {
    "world_center": {},
    "world_left": {},
    "depth_center": {},
    "picture_center": {},
}
DEPTH16 = {"depth_center.format": "depth16"}
JPEG = {"world_center.format": "jpeg", "world_left.format": "jpeg"}
QUALITY_40 = {"world_center.quality": 40, "world_left.quality": 40}
WORLD_AT_LEAST = JPEG | QUALITY_40
SLOW = {"picture_center.update_rate": 15, "depth_center.update_rate": 5}


def changes(before: Config, mbit_per_s: float) -> dict[str, Any] | None:
    change = fitting_change(before, mbit_per_s, images_mbit_per_s(before))
    return None if change is None else dict(change.values)


@pytest.mark.parametrize(
    ("mbit_per_s", "expected"),
    [
        (815, {}),
        (700, DEPTH16),
        (500, DEPTH16 | {"world_center.format": "jpeg"}),
        (200, DEPTH16 | JPEG),
        (148, DEPTH16 | JPEG | {"world_center.quality": 60}),
        (136, DEPTH16 | JPEG | {"world_center.quality": 60, "world_left.quality": 60}),
        (131, DEPTH16 | JPEG | {"world_center.quality": 40, "world_left.quality": 60}),
        (126, DEPTH16 | WORLD_AT_LEAST),
        (92, DEPTH16 | WORLD_AT_LEAST | {"picture_center.update_rate": 15}),
        (
            88,
            DEPTH16
            | WORLD_AT_LEAST
            | {"picture_center.update_rate": 15, "depth_center.update_rate": 25},
        ),
        (73, DEPTH16 | WORLD_AT_LEAST | SLOW),
        (
            38,
            DEPTH16
            | WORLD_AT_LEAST
            | {"picture_center.enabled": False, "depth_center.update_rate": 5},
        ),
        (
            35,
            WORLD_AT_LEAST
            | dict.fromkeys(("picture_center.enabled", "depth_center.enabled"), False),
        ),
        (
            18,
            {"world_left.format": "jpeg", "world_left.quality": 40}
            | dict.fromkeys(
                ("world_center.enabled", "picture_center.enabled", "depth_center.enabled"), False
            ),
        ),
        (17, None),
    ],
)
def test_formats_then_qualities_then_rates_then_streams_give_way(
    mbit_per_s: float, expected: dict[str, Any] | None
) -> None:
    assert changes(config(**RAW), mbit_per_s) == expected


def test_streams_of_one_line_of_the_table_stay_alike() -> None:
    pair = config(world_left={}, world_right={})
    assert changes(pair, 400) == {"world_left.format": "jpeg", "world_right.format": "jpeg"}


def test_a_quality_that_is_lower_already_is_kept() -> None:
    jpeg: dict[str, Any] = {"format": "jpeg", "quality": 50}
    before = config(world_center=jpeg, world_left={"format": "jpeg"})
    assert changes(before, 45) == {"world_left.quality": 60}


def test_a_change_is_by_what_streams_were_measured_to_need() -> None:
    jpeg = config(world_center={"format": "jpeg"}, picture_center={})
    change = fitting_change(jpeg, 100.0, {"world_center": 60.0, "color": 100.0})
    assert change is not None
    assert change.values == {"world_center.quality": 40, "picture_center.update_rate": 15}
    assert change.mbit_per_s == pytest.approx(30 + 50)
    only = fitting_change(jpeg, 70.0, {"world_center": 60.0})
    assert only is not None
    assert only.values == {}


def test_infrared_does_not_become_depth() -> None:
    infrared = config(depth_center={"format": "DepthRaw"})
    assert changes(infrared, 40.0) is None
    assert changes(infrared, 50.0) == {"depth_center.update_rate": 5}


SET_JPEG = "run `ml2-receiver set world_left.format=jpeg`: images then need about 34 Mbit/s"


@pytest.mark.parametrize(
    ("sections", "mbit_per_s", "words"),
    [
        ({"gaze": {}}, 100, "no images"),
        ({"world_left": {}}, None, "images need about 248 Mbit/s"),
        ({"world_left": {}}, 300, "images need about 248 Mbit/s, within the link's 300"),
        (
            {"world_left": {}},
            99.5,
            f"images need about 248 Mbit/s, more than the link's 99.5: {SET_JPEG}",
        ),
        (
            {"world_left": {"format": "jpeg", "quality": 40}, "depth_center": {"update_rate": 5}},
            20,
            "images need about 59 Mbit/s, more than the link's 20: run `ml2-receiver set"
            " depth_center.enabled=false`: images then need about 17 Mbit/s",
        ),
    ],
)
def test_it_is_said_what_to_do(
    sections: dict[str, Any], mbit_per_s: float | None, words: str
) -> None:
    asked = config(**sections)
    assert link_in_words(asked, images_mbit_per_s(asked), mbit_per_s) == words


def test_a_bound_in_the_configuration_is_what_the_link_carries() -> None:
    asked = Settings.of(config(world_left={}))
    for link, bound in (("auto", None), ("fixed", None), (100, 100.0)):
        assert bound_mbit_per_s(asked.changed({"general.link": link}).config) == bound


@pytest.mark.parametrize(
    ("link", "words"),
    [
        (
            "fixed",
            "run `ml2-receiver set general.link=auto --name robot1`: the headset then lowers",
        ),
        (
            "auto",
            "leave it to the headset, which lowers quality and rates to what the link carries",
        ),
        (5, "leave it to the headset, which lowers quality and rates to what the link carries"),
    ],
)
def test_where_no_change_fits_the_headset_lowers_values(link: Any, words: str) -> None:
    asked = Settings.of(config(world_left={"format": "jpeg"})).changed({"general.link": link})
    named = replace(asked.config, name="robot1")
    said = link_in_words(named, images_mbit_per_s(named), 5)
    assert said.startswith(f"images need about 34 Mbit/s, more than the link's 5: {words}")


SECTIONS: dict[str, dict[str, list[Any]]] = {
    "world_center": {"format": ["Grayscale", "jpeg"], "quality": [1, 50, 80, 100]},
    "world_right": {"format": ["Grayscale", "jpeg"], "stream": [0, 1]},
    "eye_temple_left": {"format": ["Grayscale", "jpeg"], "quality": [20, 90]},
    "picture_center": {"update_rate": [15, 30, 60]},
    "depth_center": {
        "format": ["Depth32", "depth16", "DepthRaw"],
        "confidence": [False, True],
        "update_rate": [5, 25, 30, 50, 60],
    },
}
# From the first to give way to the last, which always stays.
RANKS = ("eye_temple_left", "picture_center", "depth_center", "world_center", "world_right")


@given(
    chosen=st.fixed_dictionaries(
        {},
        optional={
            id: st.fixed_dictionaries({key: st.sampled_from(it) for key, it in keys.items()})
            for id, keys in SECTIONS.items()
        },
    ),
    mbit_per_s=st.floats(0, 1200),
)
def test_a_change_is_legal_and_fits_and_gives_up_streams_in_their_order(
    chosen: dict[str, dict[str, Any]], mbit_per_s: float
) -> None:
    before = config(**chosen)
    change = fitting_change(before, mbit_per_s, images_mbit_per_s(before))
    if change is None:
        assert sum(images_mbit_per_s(before).values()) > mbit_per_s
        return
    after = Settings.of(before).changed(change.values).config
    needed = sum(images_mbit_per_s(after).values())
    assert needed == pytest.approx(change.mbit_per_s)
    assert needed <= mbit_per_s + 1e-6
    enabled = [id for id in RANKS if id in chosen]
    is_off = [change.values.get(f"{id}.enabled") is False for id in enabled]
    assert is_off == sorted(is_off, reverse=True)
    assert not enabled or not is_off[-1]
    touched = {key.partition(".")[2] for key in change.values}
    if touched & {"update_rate", "enabled"}:
        images = [after.requests[id] for id in images_mbit_per_s(after)]
        assert all(it["format"] in ("jpeg", "depth16", "DepthRaw") for it in images)
        assert all(int(it.get("quality", 0)) <= 40 for it in images)

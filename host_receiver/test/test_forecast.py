"""Forecasts of the Mbit/s of images, and of changes that need less."""

from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from ml2_receiver.configuration.config import Config, parse_config
from ml2_receiver.configuration.forecast import (
    fitting_change,
    images_mbit_per_s,
    needs_in_words,
)
from ml2_receiver.configuration.settings import Settings, config_of
from ml2_receiver.errors import ConfigError

WORLD, EYE, DEPTH, COLOR = "world_center", "eye_nasal_left", "depth_center", "picture_center"
WORLD_MPX, EYE_MPX, DEPTH_MPX = 1016 * 1016e-6, 0.16, 544 * 480e-6


def config(**sections: dict[str, Any]) -> Config:
    enabled = {id: {"enabled": True} | values for id, values in sections.items()}
    return parse_config(yaml.safe_dump({"/**": {"ros__parameters": enabled}}).encode())


@pytest.mark.parametrize(
    ("section", "values", "stream", "mbit_per_s"),
    [
        (WORLD, {}, WORLD, WORLD_MPX * 8 * 30),
        (WORLD, {"quality": 40}, WORLD, WORLD_MPX * 8 * 30),
        (WORLD, {"format": "jpeg"}, WORLD, WORLD_MPX * 1.1 * 30),
        (WORLD, {"format": "jpeg", "quality": 60}, WORLD, WORLD_MPX * 1.1 * 30 * 0.65),
        (WORLD, {"format": "jpeg", "quality": 50}, WORLD, WORLD_MPX * 1.1 * 30 * 0.575),
        (WORLD, {"format": "jpeg", "quality": 95}, WORLD, WORLD_MPX * 1.1 * 30 * 3.3),
        (WORLD, {"format": "jpeg", "quality": 1}, WORLD, WORLD_MPX * 1.1 * 30 * 0.15),
        (WORLD, {"format": "jpeg", "quality": 100}, WORLD, WORLD_MPX * 1.1 * 30 * 5),
        (EYE, {}, EYE, EYE_MPX * 8 * 30),
        (EYE, {"format": "jpeg"}, EYE, EYE_MPX * 1.1 * 30),
        (COLOR, {}, "color", 1920 * 1080e-6 * 1.1 * 30),
        (COLOR, {"resolution_width": 640, "resolution_height": 480, "update_rate": 60}, "color",
         640 * 480e-6 * 1.1 * 60),
        (COLOR, {"stream": 1, "resolution_width": 1440}, "mixed_reality",
         1440 * 1080e-6 * 1.1 * 30),
        (DEPTH, {}, "depth", DEPTH_MPX * 32 * 30),
        (DEPTH, {"confidence": True}, "depth", DEPTH_MPX * 64 * 30),
        (DEPTH, {"confidence": True, "flags": True}, "depth", DEPTH_MPX * 96 * 30),
        (DEPTH, {"format": "depth16", "flags": True}, "depth", DEPTH_MPX * (2.9 + 32) * 30),
        (DEPTH, {"format": "DepthRaw", "flags": True}, "infra", DEPTH_MPX * 32 * 30),
        (DEPTH, {"update_rate": 60}, "depth", DEPTH_MPX * 32 * 30),
        (DEPTH, {"stream": 0, "update_rate": 5}, "depth", DEPTH_MPX * 32 * 5),
    ],
)  # fmt: skip
def test_a_camera_needs_its_pixels_at_its_rate(
    section: str, values: dict[str, Any], stream: str, mbit_per_s: float
) -> None:
    found = images_mbit_per_s(config(**{section: values}))
    assert found == pytest.approx({stream: mbit_per_s})


def test_only_images_are_counted() -> None:
    small = config(other_sensors={}, gaze={}, battery={})
    assert images_mbit_per_s(small) == {}
    assert needs_in_words(images_mbit_per_s(small)) == "no images"
    both = images_mbit_per_s(config(world_center={}, eye_nasal_left={}, gaze={}))
    assert list(both) == ["world_center", "eye_nasal_left"]
    assert needs_in_words(both) == "images need about 286 Mbit/s"


RAW: dict[str, dict[str, Any]] = {
    "world_center": {},
    "world_left": {},
    "depth_center": {},
    "picture_center": {},
}
JPEG = {"world_center.format": "jpeg", "world_left.format": "jpeg"}
DEPTH16 = {"depth_center.format": "depth16"}


@pytest.mark.parametrize(
    ("mbit_per_s", "changes"),
    [
        (900, {}),
        (700, {"depth_center.format": "depth16"}),
        (500, DEPTH16 | {"world_center.format": "jpeg"}),
        (200, DEPTH16 | JPEG),
        (140, DEPTH16 | JPEG | {"picture_center.update_rate": 15}),
        (
            120,
            DEPTH16 | JPEG | {"picture_center.update_rate": 15, "depth_center.update_rate": 5},
        ),
        (50, None),
    ],
)
def test_raw_images_are_compressed_before_rates_are_lowered(
    mbit_per_s: float, changes: dict[str, Any] | None
) -> None:
    change = fitting_change(config(**RAW), mbit_per_s)
    assert (None if change is None else change.values) == changes


def test_a_change_is_by_what_streams_were_measured_to_need() -> None:
    jpeg = config(world_center={"format": "jpeg"}, picture_center={})
    measured = {"world_center": 60.0, "color": 100.0}
    change = fitting_change(jpeg, 120.0, measured)
    assert change is not None
    assert (change.values, change.mbit_per_s) == ({"picture_center.update_rate": 15}, 110.0)
    assert fitting_change(jpeg, 100.0, measured) is None
    only = fitting_change(jpeg, 70.0, {"world_center": 60.0})
    assert only is not None
    assert only.values == {}


def test_infrared_does_not_become_depth() -> None:
    assert fitting_change(config(depth_center={"format": "DepthRaw"}), 40.0) is None
    change = fitting_change(config(depth_center={"format": "DepthRaw"}), 50.0)
    assert change is not None
    assert change.values == {"depth_center.update_rate": 5}


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
def test_a_change_is_legal_keeps_the_streams_and_fits(
    chosen: dict[str, dict[str, Any]], mbit_per_s: float
) -> None:
    before = config(**chosen)
    change = fitting_change(before, mbit_per_s)
    if change is None:
        assert sum(images_mbit_per_s(before).values()) > mbit_per_s
        return
    after = Settings.of(before).changed(change.values).config
    assert after.requests.keys() == before.requests.keys()
    needed = sum(images_mbit_per_s(after).values())
    assert needed == pytest.approx(change.mbit_per_s)
    assert needed <= mbit_per_s + 1e-6


def test_the_parameters_of_a_receiver_are_its_configuration() -> None:
    started = Settings.of(config(world_center={"format": "jpeg"}))
    before = started.changed({"general.link": 100}).config
    values = dict(before.values) | {"general.link": "100", "world_center.calibration": "a.yaml"}
    after = config_of(values)
    assert (after.requests, after.link) == (before.requests, before.link)
    with pytest.raises(ConfigError, match="unknown section"):
        config_of({"other.enabled": True})

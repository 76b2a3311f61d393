"""Forecasts of the Mbit/s of images."""

from typing import Any

import pytest

from configurations import only_config
from ml2_receiver.configuration.config import Config
from ml2_receiver.configuration.forecast import images_mbit_per_s
from ml2_receiver.configuration.settings import Settings, config_of
from ml2_receiver.errors import ConfigError

WORLD, EYE, DEPTH, COLOR = "world_center", "eye_nasal_left", "depth_center", "picture_center"
WORLD_MPX, EYE_MPX, DEPTH_MPX = 1016 * 1016e-6, 0.16, 544 * 480e-6


def config(**sections: dict[str, Any]) -> Config:
    return only_config({id: {"enabled": True} | values for id, values in sections.items()})


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
        (DEPTH, {"update_rate": 60}, "depth", DEPTH_MPX * 32 * 60),
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
    both = images_mbit_per_s(config(world_center={}, eye_nasal_left={}, gaze={}))
    assert list(both) == ["world_center", "eye_nasal_left"]


def test_the_parameters_of_a_receiver_are_its_configuration() -> None:
    started = Settings.of(config(world_center={"format": "jpeg"}))
    before = started.changed({"general.link": 100}).config
    values = dict(before.values) | {"general.link": "100", "world_center.calibration": "a.yaml"}
    after = config_of(values)
    assert (after.requests, after.link) == (before.requests, before.link)
    with pytest.raises(ConfigError, match="unknown section"):
        config_of({"other.enabled": True})

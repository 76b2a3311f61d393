import re
from collections.abc import Mapping
from typing import Any

import pytest

from configurations import only_config
from ml2_receiver.configuration.settings import Settings
from ml2_receiver.errors import ConfigError
from ml2_receiver.wire.messages import Link

COLOR = "picture_center"


@pytest.fixture
def settings() -> Settings:
    return Settings.of(only_config("picture_center: {enabled: true}"))


def color(settings: Settings) -> Any:
    values = settings.config.requests["color"]
    return values["resolution_width"], values["resolution_height"], values["update_rate"]


def refusal(settings: Settings, changes: Mapping[str, object], *, may_wait: bool = True) -> str:
    with pytest.raises(ConfigError) as raised:
        settings.changed(changes, may_wait=may_wait)
    return str(raised.value)


def test_a_value_that_is_legal_with_the_others_counts_at_once(settings: Settings) -> None:
    settings = settings.changed({f"{COLOR}.update_rate": 60}, may_wait=True)
    assert (color(settings), settings.pending) == ((1920, 1080, 60), ())


def test_values_wait_until_all_are_legal_together(settings: Settings) -> None:
    settings = settings.changed({f"{COLOR}.resolution_width": 1280}, may_wait=True)
    assert color(settings) == (1920, 1080, 30)
    (problem,) = settings.pending
    assert (problem.key, "found 1280x1080" in problem.message) == (
        f"{COLOR}.resolution_width",
        True,
    )
    settings = settings.changed({"world_left.enabled": True}, may_wait=True)
    assert "world_left" in settings.config.requests
    assert len(settings.pending) == 1
    settings = settings.changed({f"{COLOR}.resolution_height": 720}, may_wait=True)
    assert (color(settings), settings.pending) == ((1280, 720, 30), ())


def test_other_keys_of_a_camera_that_waits_count_at_once(settings: Settings) -> None:
    settings = settings.changed({f"{COLOR}.resolution_width": 1280}, may_wait=True)
    settings = settings.changed({f"{COLOR}.backend": "openxr"}, may_wait=True)
    assert settings.config.requests["color"]["backend"] == "openxr"
    assert color(settings) == (1920, 1080, 30)


def test_a_mode_stands_for_three_keys(settings: Settings) -> None:
    settings = settings.changed({f"{COLOR}.mode": "640x480@15"}, may_wait=True)
    assert color(settings) == (640, 480, 15)
    assert settings.values[f"{COLOR}.resolution_width"] == 640
    assert settings.parameters()[f"{COLOR}.mode"] == "640x480@15"


def test_a_mode_and_a_key_that_contradict_are_refused_in_any_order(settings: Settings) -> None:
    given = {f"{COLOR}.mode": "640x480@30", f"{COLOR}.update_rate": 15}
    for changes in (given, dict(reversed(given.items()))):
        said = refusal(settings, changes, may_wait=False)
        assert f"{COLOR}.update_rate is 15: give one of them" in said


def test_values_that_are_set_together_do_not_wait(settings: Settings) -> None:
    size = {f"{COLOR}.resolution_width": 1280, f"{COLOR}.resolution_height": 1080}
    assert "found 1280x1080" in refusal(settings, size, may_wait=False)
    both = {f"{COLOR}.stream": 1, f"{COLOR}.mode": "648x720@60"}
    assert "mixed_reality" in settings.changed(both).config.requests


@pytest.mark.parametrize("value", ["100", 100, 100.0, "1e2"])
def test_a_number_for_the_link_is_the_same_as_text(settings: Settings, value: object) -> None:
    settings = settings.changed({"general.link": value}, may_wait=True)
    assert str(settings.values["general.link"]) == "100"
    assert settings.config.link == Link(adapts=True, most_mbit_per_s=100.0)
    assert settings.changed({"general.link": "fixed"}).config.link is None


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("general.link", "slow", 'expected auto, fixed, or a number .* above 0, found "slow"'),
        ("general.link", 0, "expected auto, fixed, or a number .* above 0, found 0"),
        ("general.link", "-1", 'expected auto, fixed, or a number .* above 0, found "-1"'),
        ("world_left.enabled", 1, "expected true or false, found 1"),
        ("world_left.enabled", "yes", 'expected true or false, found "yes"'),
        ("world_left.enabled", None, "expected true or false, found nothing"),
        ("world_left.enabled", [True], "expected true or false, found a list"),
        ("world_left.enable", True, "unknown key with value true; .* did you mean enabled?"),
        ("color.enabled", True, "stream color is configured by the section picture_center"),
        ("world_lefty.enabled", True, "unknown section; .* did you mean world_left?"),
        ("imu.angular_velocity_variance", -1.0, "expected a number of at least 0, found -1.0"),
        ("tf.layout", "round", 'expected one of flat, rig, found "round"'),
        (f"{COLOR}.update_rate", 45, "one of 15, 30, 60 with stream 0, 1920x1080, found 45"),
        (f"{COLOR}.update_rate", 30.0, "expected one of 5?.*15, 30, 60, found 30.0"),
        (f"{COLOR}.mode", "1280x720", 'expected WIDTHxHEIGHT@RATE .*, found "1280x720"'),
        (f"{COLOR}.mode", 30, "expected WIDTHxHEIGHT@RATE .*, found 30"),
        (f"{COLOR}.mode", "1280x720@61", "one of 15, 30, 60 with stream 0, 1280x720, found 61"),
        (f"{COLOR}.mode", "1x1@30", "resolution_height to be one of 640x480, .* found 1x1"),
    ],
)
def test_a_wrong_value_is_refused_as_in_a_file(
    settings: Settings, name: str, value: object, said: str
) -> None:
    assert re.search(said, refusal(settings, {name: value}, may_wait="mode" not in name))

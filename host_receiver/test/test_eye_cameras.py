"""Parameters switch on eye cameras only if the configuration file or the start allows it."""

from collections.abc import Mapping

import pytest

from configurations import only_config
from ml2_receiver.configuration.settings import Settings
from ml2_receiver.errors import ConfigError

SIDES = ("nasal_left", "nasal_right", "temple_left", "temple_right")
EYES = [f"eye_{it}" for it in SIDES]


def settings(sections: str = "battery: {enabled: true}") -> Settings:
    return Settings.of(only_config(sections))


def refusal(settings: Settings, changes: Mapping[str, object]) -> str:
    with pytest.raises(ConfigError) as refused:
        settings.changed(changes, by_peer=True)
    return str(refused.value)


def test_no_eye_camera_is_switched_on_by_a_parameter_alone() -> None:
    for eye in EYES:
        said = refusal(settings(), {f"{eye}.enabled": True})
        assert said.startswith(f"{eye}.enabled: ")
        assert "write general.eye_cameras: allowed" in said
    all_at_once = {f"{eye}.enabled": True for eye in EYES} | {"world_left.enabled": True}
    assert len(refusal(settings(), all_at_once).splitlines()) == len(EYES)


def test_a_parameter_does_not_allow_it_either() -> None:
    allowed = {"general.eye_cameras": "allowed"}
    assert "general.eye_cameras: expected refused" in refusal(settings(), allowed)
    both = refusal(settings(), {**allowed, "eye_nasal_left.enabled": True})
    assert "eye_nasal_left.enabled" in both
    assert "general.eye_cameras: expected refused" in both


def test_other_values_of_eye_cameras_and_other_sensors_are_anybodys() -> None:
    changes = {"eye_nasal_left.quality": 50, "world_left.enabled": True, "gaze.enabled": True}
    changed = settings().changed(changes, by_peer=True)
    assert {"world_left", "gaze"} < set(changed.config.requests)
    assert changed.values["eye_nasal_left.quality"] == 50


def test_where_the_file_allows_them_all_may_be_switched_on() -> None:
    allowed = settings("general: {eye_cameras: allowed}")
    changed = allowed.changed({f"{eye}.enabled": True for eye in EYES}, by_peer=True)
    assert set(EYES) < set(changed.config.requests)
    again = changed.changed({f"{EYES[0]}.enabled": False}, by_peer=True)
    assert EYES[0] in again.changed({f"{EYES[0]}.enabled": True}, by_peer=True).config.requests


def test_a_file_that_enables_one_allows_that_one() -> None:
    one = settings("eye_temple_left: {enabled: true}")
    off = one.changed({"eye_temple_left.enabled": False}, by_peer=True)
    assert not off.config.requests
    on = off.changed({"eye_temple_left.enabled": True}, by_peer=True)
    assert "eye_temple_left" in on.config.requests
    assert "eye_temple_right.enabled" in refusal(on, {"eye_temple_right.enabled": True})


def test_what_the_operator_gives_at_the_start_counts_as_the_file() -> None:
    started = settings().changed({"eye_nasal_left.enabled": True})
    assert "eye_nasal_left" in started.config.requests
    off = started.changed({"eye_nasal_left.enabled": False}, by_peer=True)
    on = off.changed({"eye_nasal_left.enabled": True}, by_peer=True)
    assert "eye_nasal_left" in on.config.requests
    assert "eye_nasal_right" in refusal(on, {"eye_nasal_right.enabled": True})
    allowed = settings().changed({"general.eye_cameras": "allowed"})
    assert allowed.changed({"eye_nasal_right.enabled": True}, by_peer=True)


def test_what_others_switched_off_stays_theirs_to_switch_on_after_other_changes() -> None:
    one = settings("eye_temple_left: {enabled: true}")
    off = one.changed({"eye_temple_left.enabled": False}, by_peer=True)
    other = off.changed({"battery.enabled": True}, by_peer=True)
    assert other.changed({"eye_temple_left.enabled": True}, by_peer=True)


@pytest.mark.parametrize("value", ["yes", True, "Allowed", ""])
def test_the_key_has_two_values(value: object) -> None:
    assert "expected one of refused, allowed" in refusal(settings(), {"general.eye_cameras": value})

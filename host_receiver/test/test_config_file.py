from pathlib import Path

import pytest

from ml2_receiver.configuration.app_rules import NameRules
from ml2_receiver.configuration.config import Config, load_config, parse_config
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.configuration.settings import Settings
from ml2_receiver.errors import ConfigError

TEXT = """\
# The laboratory's
/config_ML_node:
  ros__parameters:
    world_left.enabled: true  # flat
    gaze:
        enabled: false        # indented by four
    tf: {layout: "flat"}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "config.yaml"
    file.write_text(TEXT)
    return file


def changed(file: Path, **changes: object) -> Config:
    named = {name.replace("__", "."): value for name, value in changes.items()}
    return Settings.of(load_config(file)).changed(named).config


def test_only_values_that_changed_are_written(file: Path) -> None:
    config = changed(file, world_left__enabled=False, gaze__enabled=True, battery__enabled=True)
    ConfigFile(file).save(config)
    assert "# The laboratory's\n" in file.read_text()
    assert "# indented by four\n" in file.read_text()
    assert 'layout: "flat"' in file.read_text()
    assert load_config(file) == config


def test_values_are_written_where_the_receivers_are(file: Path) -> None:
    other = "/driver: {ros__parameters: {gaze: {enabled: false}}}\n"
    own = "robot1: {ml2_receiver: {ros__parameters: {tf: {layout: flat}}}}\n"
    file.write_text(other + "/**: {ros__parameters: {planner: {speed: 1}}}\n" + own)
    config = changed(file, gaze__enabled=True)
    ConfigFile(file).save(config)
    assert load_config(file).values == config.values
    assert file.read_text().startswith(other)
    assert "tf: {layout: flat}, gaze: {enabled: true}" in file.read_text()


def test_a_file_for_several_keeps_what_is_of_the_others(file: Path) -> None:
    robots = [
        f"/{it}/ml2_receiver: {{ros__parameters: {{tf: {{layout: flat}}}}}}\n"
        for it in ("robot1", "robot2")
    ]
    last = "/**: {ros__parameters: {battery: {enabled: false}}}\n"
    file.write_text("".join([*robots, last]))
    of_one = ConfigFile(file, node="/robot1/ml2_receiver")
    changes = {"tf.layout": "rig", "gaze.enabled": True, "battery.enabled": True}
    config = Settings.of(of_one.load()).changed(changes).config
    of_one.save(config)
    assert of_one.load().values == config.values
    first, second, third = file.read_text().splitlines()
    assert "tf: {layout: rig}, gaze: {enabled: true}" in first
    assert f"{second}\n" == robots[1]
    assert f"{third}\n" == last.replace("false", "true")


def test_a_mode_is_written_as_a_mode(file: Path) -> None:
    file.write_text(TEXT + "    picture_center: {mode: 640x480@15}\n")
    config = changed(file, picture_center__mode="1280x720@30")
    ConfigFile(file).save(config)
    assert "picture_center: {mode: 1280x720@30}" in file.read_text()
    assert load_config(file).values == config.values


def test_a_number_for_the_link_stays_as_the_user_wrote_it(file: Path) -> None:
    file.write_text(TEXT + "    general: {link: 100.0}\n")
    ConfigFile(file).save(changed(file, general__link="100", battery__enabled=True))
    assert "{link: 100.0}" in file.read_text()
    ConfigFile(file).save(changed(file, general__link="50"))
    assert "{link: 50}" in file.read_text()


def test_names_are_written_as_a_list(file: Path) -> None:
    file.write_text(TEXT + "    app: {call: [/robot/stop]}\n")
    config = changed(file, app__call=["/robot/stop", "/robot/*"], app__offer=["/a"])
    ConfigFile(file).save(config)
    assert "call: [/robot/stop, /robot/*]" in file.read_text()
    assert load_config(file).app == config.app
    assert config.app.call == NameRules(("/robot/stop", "/robot/*"))


def test_a_file_of_one_without_any_begins_as_the_packaged_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    file = ConfigFile.of_user()
    assert (file.path, file.is_packaged) == (tmp_path / "ml2-sensors/config.yaml", True)
    config = Settings.of(file.load()).changed({"battery.enabled": True}).config
    file.save(config)
    assert not file.is_packaged
    assert file.load() == config
    assert "# Tracking cameras." in file.path.read_text()


def test_a_file_in_the_folder_of_before_is_read_until_there_is_a_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    old, new = tmp_path / "ml2_receiver/config.yaml", tmp_path / "ml2-sensors/config.yaml"
    for file in (old, new):
        file.parent.mkdir()
        file.write_text(TEXT)
        assert ConfigFile.of_user().path == file


def test_a_file_that_was_named_has_to_be_there(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cannot be read: No such file"):
        ConfigFile(tmp_path / "config.yaml").load()


def test_a_read_only_file_stays_as_it_is(file: Path) -> None:
    config = changed(file, gaze__enabled=True)
    file.chmod(0o444)
    with pytest.raises(ConfigError, match=r"config.yaml: cannot be written: it is read-only"):
        ConfigFile(file).save(config)
    assert file.read_text() == TEXT
    assert list(file.parent.iterdir()) == [file]


def test_what_stands_there_and_is_no_configuration_stays_as_it_is(file: Path) -> None:
    config = changed(file, gaze__enabled=True)
    file.write_text("shopping: list")
    with pytest.raises(ConfigError, match="unknown node"):
        ConfigFile(file).save(config)
    assert file.read_text() == "shopping: list"


def test_a_section_given_twice_is_not_written(file: Path) -> None:
    twice = TEXT + "    world_right: {enabled: true}\n    world_right: {update_rate: 30}\n"
    file.write_text(twice)
    config = changed(file, gaze__enabled=True)
    with pytest.raises(ConfigError, match=r"config.yaml:9: cannot be written: .*world_right"):
        ConfigFile(file).save(config)
    assert file.read_text() == twice


def test_a_folder_that_cannot_be_made_is_the_reason(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    file = ConfigFile(tmp_path / "file" / "config.yaml", is_optional=True)
    with pytest.raises(ConfigError, match=r"cannot be written: (Not a directory|File exists)"):
        file.save(parse_config(TEXT.encode()))


def test_a_link_and_permissions_stay(file: Path, tmp_path: Path) -> None:
    file.chmod(0o640)
    link = tmp_path / "link.yaml"
    link.symlink_to(file)
    ConfigFile(link).save(changed(file, gaze__enabled=True))
    assert link.is_symlink()
    assert file.stat().st_mode & 0o777 == 0o640
    assert "gaze" in load_config(file).requests

"""Files of the user that are none: pipes, devices, folders. No command waits for them."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from configurations import only
from ml2_receiver.configuration.config import load_config
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.configuration.whole_file import open_file, read_file, replace_file
from ml2_receiver.errors import ConfigError, KeysError
from ml2_receiver.security.identity import Identity
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_tools.doctor.bundle import text_of
from ros_processes import Child

CONFIG = only("battery: {enabled: true}")
KINDS = ["pipe", "terminal", "null", "zero", "folder", "link to a pipe"]


@pytest.fixture(params=KINDS)
def special(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Path]:
    path = tmp_path / "config.yaml"
    match request.param:
        case "pipe":
            os.mkfifo(path)
        case "terminal":
            leader, follower = os.openpty()
            path.symlink_to(os.ttyname(follower))
            yield path
            os.close(leader)
            os.close(follower)
            return
        case "null" | "zero" as name:
            path.symlink_to(f"/dev/{name}")
        case "folder":
            path.mkdir()
        case _:
            os.mkfifo(tmp_path / "pipe")
            path.symlink_to(tmp_path / "pipe")
    yield path


def test_what_is_no_regular_file_is_neither_read_nor_replaced(special: Path) -> None:
    target = special.resolve()
    before = target.lstat()
    for read in (open_file, lambda it: read_file(it, 10), lambda it: replace_file(it, b"new")):
        for path in (special, target):
            with pytest.raises(OSError, match="expected a regular file"):
                read(path)
    after = target.lstat()
    assert (after.st_mode, after.st_ino) == (before.st_mode, before.st_ino)
    assert {it.name for it in special.parent.iterdir()} <= {special.name, "pipe"}


def test_a_configuration_is_a_regular_file(special: Path, tmp_path: Path) -> None:
    good = tmp_path / "good"
    good.mkdir()
    (good / "config.yaml").write_text(CONFIG)
    config = load_config(good / "config.yaml")
    with pytest.raises(ConfigError, match="cannot be read: expected a regular file"):
        load_config(special)
    for file in (ConfigFile(special), ConfigFile(special, is_optional=True)):
        with pytest.raises(ConfigError, match="cannot be read: expected a regular file"):
            file.load()
        with pytest.raises(ConfigError, match="cannot be written: expected a regular file"):
            file.save(config)
    assert "expected a regular file" in text_of(special)


@pytest.mark.parametrize("name", ["receiver.key", "receiver.pem"])
def test_a_key_is_a_regular_file(name: str, special: Path, tmp_path: Path) -> None:
    Identity.of(tmp_path / "keys")
    (tmp_path / "keys" / name).unlink()
    (tmp_path / "keys" / name).symlink_to(special)
    with pytest.raises(KeysError, match=f"{name}: expected a regular file"):
        Identity.of(tmp_path / "keys")


def test_a_paired_device_is_a_regular_file(special: Path, tmp_path: Path) -> None:
    warnings: list[str] = []
    folder = tmp_path / "keys" / "devices"
    folder.mkdir(mode=0o755, parents=True)
    (folder / f"{'0' * 64}.json").symlink_to(special)
    assert PairedDevices(tmp_path / "keys", warnings.append).load() == []
    assert "expected a regular file" in "".join(warnings)


ZENOH = ("run", "--no-ros", "--insecure", "--zenoh", "tcp/127.0.0.1:9", "--zenoh-config")


@pytest.mark.parametrize(
    "words", [("doctor",), ("config", "check"), ("run", "--insecure", "--config"), ZENOH]
)
def test_commands_end_at_what_is_no_file(words: tuple[str, ...], tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with Child("-m", "ml2_receiver", *words, str(pipe)) as child:
        assert child.wait() in (1, 2)
        said = [*child.errors]
        while child.has_line(0.1):
            pass
    assert not any("Traceback" in it for it in said)

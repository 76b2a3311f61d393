"""Other users of the machine can read neither recordings nor keys, whatever the umask is."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

import bag_scene
import sound_bag
from bag_readers import mcap_file
from ml2_receiver.cli import main
from ml2_receiver.recording.bag_folder import make_folder
from ml2_receiver.recording.bag_topic import BagTopic
from ml2_receiver.security.identity import Identity
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_receiver.table.stream_table import Qos

BATTERIES = BagTopic("/battery", "sensor_msgs/msg/BatteryState", Qos(10))


@pytest.fixture(params=[0o022, 0o000, 0o002, 0o077], ids=oct, autouse=True)
def umask(request: pytest.FixtureRequest) -> Iterator[None]:
    before = os.umask(request.param)
    yield
    os.umask(before)


def check_private(top: Path) -> int:
    """Checks the modes of a folder and of all below it, and returns how many files there are."""
    files = 0
    for path in (top, *top.rglob("*")):
        mode = stat.S_IMODE(path.stat().st_mode)
        assert oct(mode) == oct(0o700 if path.is_dir() else 0o600), path
        files += path.is_file()
    return files


def test_a_recording_is_its_owners_alone(tmp_path: Path) -> None:
    bag_scene.record(tmp_path / "bags" / "today" / "walk", 3)
    assert check_private(tmp_path / "bags") == 2


def test_each_file_of_a_split_recording_is_its_owners_alone(tmp_path: Path) -> None:
    writer = bag_scene.new_writer(tmp_path / "walk", BATTERIES, split_bytes=1)
    writer.write(BATTERIES, 1, bag_scene.battery(1))
    writer.flush()
    writer.close()
    assert check_private(tmp_path / "walk") == 3


def test_a_recording_that_runs_and_one_that_a_full_disk_has_ended_are_their_owners_alone(
    tmp_path: Path,
) -> None:
    writer = bag_scene.new_writer(tmp_path / "walk")
    assert check_private(tmp_path / "walk") == 2
    writer.abandon()
    assert check_private(tmp_path / "walk") == 2


def test_a_recording_that_replaces_one_that_others_could_read_is_its_owners_alone(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "walk"
    bag_scene.record(folder, 3)
    folder.chmod(0o755)
    mcap_file(folder).chmod(0o644)
    make_folder(folder, is_overwriting=True)
    assert check_private(folder) == 0


def test_folders_that_exist_keep_their_permissions(tmp_path: Path) -> None:
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o755)
    bag_scene.record(shared / "walk", 3)
    assert stat.S_IMODE(shared.stat().st_mode) == 0o755


def test_exported_images_are_their_owners_alone(tmp_path: Path) -> None:
    messages = sound_bag.sound()
    bag = sound_bag.written(tmp_path / "bag", [sound_bag.config(), *messages])
    out = tmp_path / "out"
    assert main(["export", "--euroc", str(out), "--bag", str(bag), "--cameras", "world_left"]) == 0
    assert check_private(out / "mav0") > 2


def test_keys_and_paired_devices_are_their_owners_alone(tmp_path: Path) -> None:
    keys = tmp_path / "home" / "keys"
    Identity.of(keys)
    PairedDevices(keys).add("a", "b", Identity.of(tmp_path / "other").certificate)
    assert check_private(tmp_path / "home") == 3

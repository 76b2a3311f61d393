"""Message types: their classes, whatever a device calls them, and their hashes."""

import sys
from pathlib import Path

import pytest

from message_definitions import typestore
from ml2_receiver.generated.type_hashes import HASHES
from ml2_receiver.recording.message_definitions import DEFINITIONS
from ml2_receiver.topics.message_types import message_class

pytest.importorskip("rclpy", reason="rclpy is not installed")

# rosbags takes char for uint8, ROS for int8.
_DIFFERENT_IN_ROSBAGS = {"std_msgs/msg/Char"}


def test_a_type_is_found_by_its_name() -> None:
    assert message_class("std_msgs/msg/Float32")(data=0.5).data == 0.5


@pytest.mark.parametrize("name", ["my_msgs/msg/Thing", "std_msgs/msg/Thing"])
def test_a_type_that_is_not_installed_is_named(name: str) -> None:
    with pytest.raises(ImportError, match=r"my_msgs|Thing"):
        message_class(name)


def test_another_package_is_not_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "harmful" / "msg").mkdir(parents=True)
    (tmp_path / "harmful/__init__.py").write_text("raise AssertionError('was run')")
    (tmp_path / "harmful/msg/__init__.py").write_text("class Thing: pass")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(ImportError, match="no package harmful of ROS messages"):
        message_class("harmful/msg/Thing")
    assert "harmful" not in sys.modules


def test_hashes_are_those_which_rosbags_makes_of_the_definitions() -> None:
    store = typestore()
    types = HASHES.keys() - _DIFFERENT_IN_ROSBAGS
    assert {it: HASHES[it] for it in types} == {it: store.hash_rihs01(it) for it in types}


def test_every_type_that_is_sent_has_a_hash() -> None:
    assert DEFINITIONS.keys() <= HASHES.keys()
    assert "diagnostic_msgs/msg/DiagnosticArray" in HASHES

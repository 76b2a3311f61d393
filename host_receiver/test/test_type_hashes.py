"""The hashes of message types, against what another program makes of the types' definitions."""

from message_definitions import typestore
from ml2_receiver.generated.type_hashes import HASHES
from ml2_receiver.recording.message_definitions import DEFINITIONS

# rosbags takes char for uint8, ROS for int8.
_DIFFERENT_IN_ROSBAGS = {"std_msgs/msg/Char"}


def test_hashes_are_those_which_rosbags_makes_of_the_definitions() -> None:
    store = typestore()
    types = HASHES.keys() - _DIFFERENT_IN_ROSBAGS
    assert {it: HASHES[it] for it in types} == {it: store.hash_rihs01(it) for it in types}


def test_every_type_that_is_sent_has_a_hash() -> None:
    assert DEFINITIONS.keys() <= HASHES.keys()
    assert "diagnostic_msgs/msg/DiagnosticArray" in HASHES

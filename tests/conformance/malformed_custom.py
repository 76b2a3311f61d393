"""Topics that a device must not name so."""

from typing import Any

from bodies import CUSTOM
from frame_bytes import json_frame
from malformed_case import Case, error


def cases() -> dict[str, Case]:
    """CHANNELs of `custom` that ROS or the table forbid."""

    def case(why: str, *bodies: dict[str, Any]) -> Case:
        sent = b"".join(json_frame("CHANNEL", CUSTOM | body) for body in bodies)
        return Case("configuring", "control", sent, error("channel"), why)

    def named(why: str, name: str) -> Case:
        return case(why, {"topic": name})

    longest = "a" * 64
    return {
        "CustomOutside": named("Only below custom.", "room_temperature"),
        "CustomGlobal": named("A device cannot name global topics.", "/custom/a"),
        "CustomWithoutName": named("An empty name.", "custom/"),
        "CustomDeeper": named("One name, not a path.", "custom/a/b"),
        "CustomParent": named("Not a name of ROS.", "custom/.."),
        "CustomPrivate": named("Not a name of ROS.", "custom/~a"),
        "CustomSubstitution": named("Not a name of ROS.", "custom/{node}"),
        "CustomDigitFirst": named("Names of ROS begin with a letter.", "custom/1a"),
        "CustomUnderscoreFirst": named("Hidden in ROS.", "custom/_a"),
        "CustomUnderscoreLast": named("ROS forbids it.", "custom/a_"),
        "CustomUnderscores": named("ROS forbids it.", "custom/a__b"),
        "CustomNotAscii": named("Not a letter of ROS.", "custom/\u00e4"),
        "CustomLineEnd": named("Not a letter of ROS.", "custom/a\n"),
        "CustomNameTooLong": named("At most 64.", f"custom/{longest}b"),
        "CustomService": case("Messages only.", {"type": "std_srvs/srv/Trigger"}),
        "CustomTypeOfDds": case("Not a name of ROS.", {"type": "std_msgs::msg::dds_::String_"}),
        "CustomTypePath": case("Not a package.", {"type": "../msg/String"}),
        "CustomTypeTooLong": case("At most 128.", {"type": f"a/msg/{'A' * 123}"}),
        "CustomOtherRole": case("The table's role.", {"role": "image"}),
        "CustomOtherQos": case("The table's QoS.", {"qos": "latched"}),
        "CustomOtherLane": case("The table's lane.", {"lane": "world_left"}),
        "CustomTypeChanges": case("A name keeps its type.", {}, {"type": "std_msgs/msg/String"}),
        "CustomTooMany": case(
            "One more than 32 of one instance.",
            *({"id": 100 + number, "topic": f"custom/topic{number}"} for number in range(33)),
        ),
        "CustomSameId": case("The id is another topic's.", {}, {"topic": "custom/b"}),
        "CustomSameTopic": case("The topic has an id.", {}, {"id": 41}),
    }

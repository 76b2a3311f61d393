"""A package of messages as a user has one, installed as ROS installs it."""

import json
from pathlib import Path

import numpy as np
from rosbags.typesys import get_types_from_msg
from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_generator_type_description import generate_type_hash

from message_definitions import typestore
from ml2_tools.messages.descriptions import share

DEFINITIONS = {
    "Finger": "int16[3] joints\nstring object\n",
    "Grip": """\
uint8 OPEN=0
uint8 CLOSED=1
string GREETING="the robot's \\"hand\\""
std_msgs/Header header
float32[<=4] forces [0.5, 1.0]
string<=8 tool "hand"
Finger[] fingers
uint8 state 1
bool in true
geometry_msgs/Point[2] tips
""",
}
TYPE = "arm_msgs/msg/Grip"


def install(prefix: Path) -> None:
    """Writes prefix/share/arm_msgs, from which prefix can be in AMENT_PREFIX_PATH."""
    package = prefix / "share/arm_msgs"
    (package / "msg").mkdir(parents=True)
    files = [Path("msg") / f"{name}.msg" for name in DEFINITIONS]
    for file in files:
        (package / file).write_text(DEFINITIONS[file.stem], "utf-8")
        convert_msg_to_idl(package, "arm_msgs", file, package / "msg")
    arguments = prefix / "arguments.json"
    used = ("std_msgs", "geometry_msgs", "builtin_interfaces")
    asked = {
        "package_name": "arm_msgs",
        "output_dir": str(package),
        "idl_tuples": [f"{package}:{file.with_suffix('.idl')}" for file in files],
        "include_paths": [f"{it}:{share(it)}" for it in used],
    }
    arguments.write_text(json.dumps(asked), "utf-8")
    generate_type_hash(str(arguments))


def payloads() -> list[bytes]:
    """Returns the bytes that rosbags writes: for ROS's default values, and for others."""
    store = typestore()
    for name, text in DEFINITIONS.items():
        store.register(get_types_from_msg(text, f"arm_msgs/msg/{name}"))
    types = store.types
    point = types["geometry_msgs/msg/Point"]
    header = types["std_msgs/msg/Header"]
    time = types["builtin_interfaces/msg/Time"]
    grip, finger = types[TYPE], types["arm_msgs/msg/Finger"]
    origin = point(0.0, 0.0, 0.0)
    default = grip(
        header(time(0, 0), ""), np.array([0.5, 1], "f4"), "hand", [], 1, True, [origin, origin]
    )
    other = grip(
        header(time(-7, 5), "grip_frame"),
        np.array([1.5, -2, 3], "f4"),
        "gripper8",
        [finger(np.array([1, -2, 32767], "i2"), it) for it in ("cup", "", "größer")],
        0,
        False,
        [point(1.0, -2.0, 3.5), origin],
    )
    return [bytes(store.serialize_cdr(it, TYPE)) for it in (default, other)]

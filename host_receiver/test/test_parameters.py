"""The receiver's parameters and services, as `ros2 param` and `ros2 service` meet them."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from ml2_receiver.configuration.config import load_config
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.messages import Link
from mock_device import MockDevice
from ros_processes import Child, Client, Receiver, Subscriber

pytest.importorskip("rclpy", reason="rclpy is not installed")

ROOT = Path(__file__).resolve().parents[2]
CONFIG = """# mine
/config_ML_node:
  ros__parameters:
    world_left:
      enabled: true  # the left one
      format: Grayscale
    picture_center: {enabled: true}
    world_center: {enabled: false}
    other_sensors: {enabled: false}
"""
COLOR = "picture_center"
# Values that ROS itself refuses, and one of those that test_settings.py has.
REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"world_left.enabled": [True]}, "found a list"),
    ({"general.topic_name": "/other"}, "read-only"),
    (
        {"app.call": "/robot/stop"},
        "found /robot/stop: ROS parameters cannot change it; write it in",
    ),
    ({"qos_overrides./magic_leap2/log.publisher.depth": 3}, "read-only"),
    ({f"{COLOR}.resolution_width": 1280, "battery.enabled": True}, "found 1280x1080"),
]


def nested(values: dict[str, Any]) -> dict[str, Any]:
    """Parameters as `ros2 param dump` writes them: one mapping for each part of a name."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *path, last = name.split(".")
        branch = tree
        for part in path:
            branch = branch.setdefault(part, {})
        branch[last] = value
    return tree


def test_every_key_is_a_parameter_with_what_it_may_be(client: Client) -> None:
    keys = {f"{s.id}.{key}": s for s in load_table().sections.values() for key in s.keys}
    modes = {f"{section.id}.mode" for section in load_table().sections.values() if section.modes}
    names = set(client.ask("names"))
    assert keys.keys() | modes <= names
    described = dict(zip(keys, client.ask("describe", *keys), strict=True))
    assert all(found["description"] and found["constraints"] for found in described.values())
    read_only = [name for name, found in described.items() if found["read_only"]]
    assert read_only == ["general.topic_name"]
    assert described[f"{COLOR}.update_rate"]["integers"] == [[15, 60, 15]]
    assert described[f"{COLOR}.update_rate"]["constraints"].startswith("one of 15, 30, 60; ")
    assert described["imu.angular_velocity_variance"]["numbers"] == [0.0]
    assert described["tf.layout"]["constraints"] == "one of flat, rig"
    (mode,) = client.ask("describe", f"{COLOR}.mode")
    assert "stream 1: 1944x2160, 2880x2160 at 30 Hz" in mode["constraints"]
    assert client.ask("get", "world_left.enabled", f"{COLOR}.mode") == [True, "1920x1080@30"]
    overrides = [name for name in names if name.startswith("qos_overrides./magic_leap2/log.")]
    assert all(found["read_only"] for found in client.ask("describe", *overrides))


def test_a_parameter_renegotiates(client: Client, device: MockDevice) -> None:
    assert client.ask("set", {"battery.enabled": True}) == [[True, ""]]
    asked = device.reconfigure()
    assert set(asked.streams) == {"world_left", "color", "battery", "tf"}
    device.expect_start(asked.request)
    with Subscriber("/magic_leap2/battery", "sensor_msgs/msg/BatteryState") as subscriber:
        assert subscriber.publisher["reliability"] == "RELIABLE"
    assert client.ask("enable", "battery", False) == [True, ""]
    assert "battery" not in device.reconfigure().streams


def test_the_link_is_text_and_changes_alone(
    client: Client, device: MockDevice, config: Path
) -> None:
    assert client.ask("get", "general.link") == ["auto"]
    for value, text, link in (
        ("100", "100", Link(adapts=True, most_mbit_per_s=100.0)),
        ("fixed", "fixed", None),
        (50, "50", Link(adapts=True, most_mbit_per_s=50.0)),
        (2.5, "2.5", Link(adapts=True, most_mbit_per_s=2.5)),
    ):
        assert client.ask("set", {"general.link": value}) == [[True, ""]]
        asked = device.reconfigure()
        assert (asked.link, set(asked.streams)) == (link, {"world_left", "color", "tf"})
        device.expect_start(asked.request)
        assert client.ask("get", "general.link") == [text]
    assert client.ask("set", {"save.keys": "general.link"}) == [[True, ""]]
    assert client.ask("trigger", "save_config")[0]
    assert "link: 2.5" in config.read_text()
    config.write_text(config.read_text().replace("link: 2.5", "link: 7"))
    assert client.ask("trigger", "reload") == [True, ""]
    assert device.reconfigure().link == Link(adapts=True, most_mbit_per_s=7.0)
    assert client.ask("get", "general.link") == ["7"]


def test_values_legal_only_together_wait_or_come_together(
    client: Client, device: MockDevice, receiver: Receiver
) -> None:
    ((is_set, reason),) = client.ask("set", {f"{COLOR}.resolution_width": 1280})
    assert is_set
    assert "found 1280x1080: waiting" in reason
    assert client.ask("get", f"{COLOR}.resolution_width", f"{COLOR}.mode") == [1280, "1920x1080@30"]
    assert client.ask("set", {f"{COLOR}.resolution_height": 720}) == [[True, ""]]
    asked = device.reconfigure()
    assert asked.streams["color"]["resolution_width"] == 1280
    device.expect_start(asked.request)
    assert client.ask("get", f"{COLOR}.mode") == ["1280x720@30"]
    assert client.ask("set", {f"{COLOR}.mode": "640x480@60"}) == [[True, ""]]
    asked = device.reconfigure()
    assert asked.streams["color"]["update_rate"] == 60
    device.expect_start(asked.request)
    assert client.ask("get", f"{COLOR}.resolution_height") == [480]
    stream = {f"{COLOR}.stream": 1, f"{COLOR}.mode": "648x720@60"}
    assert client.ask("set_atomically", stream) == [True, ""]
    assert "mixed_reality" in device.reconfigure().streams
    assert any("1280x1080: waiting" in line for line in receiver.errors)


def test_a_refused_value_leaves_everything_as_it_was(client: Client, device: MockDevice) -> None:
    for changes, reason in REFUSED:
        is_set, said = client.ask("set_atomically", {"battery.enabled": True, **changes})
        assert (is_set, reason in said) == (False, True), (changes, said)
        assert client.ask("get", "battery.enabled", f"{COLOR}.mode") == [False, "1920x1080@30"]
    client.ask("enable", "gaze", True)
    assert set(device.reconfigure().streams) == {"world_left", "color", "tf", "gaze"}


def test_stop_and_start_keep_session_and_topics(client: Client, device: MockDevice) -> None:
    assert client.ask("trigger", "stop")[0]
    assert device.reconfigure().streams == {}
    with Subscriber("/magic_leap2/world_left/image_raw", "sensor_msgs/msg/Image"):
        pass
    assert client.ask("trigger", "start")[0]
    asked = device.reconfigure()
    device.expect_start(asked.request)
    assert "world_left" in asked.streams


def test_save_and_reload(client: Client, device: MockDevice, config: Path) -> None:
    config.write_text(config.read_text().replace("left one", "left camera"))
    client.ask("set", {f"{COLOR}.mode": "640x480@15", "tf.layout": "rig"})
    device.reconfigure()
    client.ask("set", {"save.keys": f" tf.layout  {COLOR}.mode "})
    assert client.ask("trigger", "save_config") == [True, f"written to {config}"]
    saved = config.read_text()
    assert "# mine\n/config_ML_node:\n" in saved
    assert "enabled: true  # the left camera\n" in saved
    assert load_config(config).requests["color"]["resolution_width"] == 640
    assert load_config(config).requests["tf"]["layout"] == "rig"
    config.write_text(saved.replace("rig", "flat"))
    assert client.ask("get", "tf.layout") == ["rig"]
    assert client.ask("trigger", "reload") == [True, ""]
    assert client.ask("get", "tf.layout") == ["flat"]
    config.write_text(saved.replace("rig", "round"))
    is_loaded, reason = client.ask("trigger", "reload")
    assert (is_loaded, f"{config}:" in reason) == (False, True)
    assert client.ask("get", "tf.layout") == ["flat"]


def test_parameters_given_to_ros_go_before_the_file_even_when_it_is_reloaded(
    config: Path, tmp_path: Path
) -> None:
    file = tmp_path / "more.yaml"
    file.write_text("/ml2_receiver: {ros__parameters: {imu: {angular_velocity_variance: 0.5}}}")
    given = ("world_left.enabled:=false", "general.topic_name:=other", "general.link:=100")
    options = (
        "--ros-args",
        *(word for it in given for word in ("-p", it)),
        "--params-file",
        str(file),
    )
    with (
        Receiver(config, *options) as receiver,
        Client() as client,
        MockDevice(receiver.address, says_ping=True) as device,
    ):
        asked = device.reach_configure()
        assert asked.link == Link(adapts=True, most_mbit_per_s=100.0)
        device.answer(asked)
        device.expect_start(asked.request)
        assert client.ask("trigger", "reload") == [True, ""]
        names = ("world_left.enabled", "imu.angular_velocity_variance", f"{COLOR}.enabled")
        assert client.ask("get", "general.link", *names) == ["100", False, 0.5, True]
        with Subscriber("/other/color/camera_info", "sensor_msgs/msg/CameraInfo"):
            pass


def test_a_file_of_ros_may_have_sections_of_other_nodes(config: Path, tmp_path: Path) -> None:
    file = tmp_path / "all.yaml"
    file.write_text("/**: {ros__parameters: {world_leftt: {enabled: true}, gaze: {enabled: true}}}")
    thesis = tmp_path / "thesis.yaml"
    thesis.write_text("/config_ML_node: {ros__parameters: {battery: {enabled: true}}}")
    files = [word for it in (file, thesis) for word in ("--params-file", str(it))]
    with Receiver(config, "--ros-args", *files) as receiver, Client() as client:
        assert client.ask("get", "gaze.enabled", "battery.enabled") == [True, False]
    (nothing,) = [line for line in receiver.errors if "has nothing for" in line]
    assert f"{thesis} has nothing for /ml2_receiver: it is for /config_ML_node" in nothing
    (told,) = [line for line in receiver.errors if "world_leftt" in line]
    assert "no section of this node, and ignored" in told
    assert "did you mean world_left?" in told


def test_a_dump_of_all_parameters_can_be_given_back(config: Path, tmp_path: Path) -> None:
    with Receiver(config), Client() as client:
        assert client.ask("set", {f"{COLOR}.mode": "640x480@15"}) == [[True, ""]]
        names = client.ask("names")
        values = dict(zip(names, client.ask("get", *names), strict=True))
    dump = tmp_path / "dump.yaml"
    dump.write_text(yaml.safe_dump({"/ml2_receiver": {"ros__parameters": nested(values)}}))
    for file, *options in ((dump,), (config, "--ros-args", "--params-file", str(dump))):
        with Receiver(file, *options), Client() as client:
            assert client.ask("get", *names) == list(values.values())
    dump.write_text(dump.read_text().replace("mode: 640x480@15", "mode: 1280x720@30"))
    command = ("-m", "ml2_receiver", "run", "--listen", "127.0.0.1:0", "--insecure", "--config")
    for file, *options in ((dump,), (config, "--ros-args", "--params-file", str(dump))):
        with Child(*command, str(file), *options) as child:
            assert child.wait() == 2
        assert any(f"{COLOR}.mode: " in line for line in child.errors), child.errors


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("world_left.enabled:=7", "ROS parameters: world_left.enabled: expected true or false"),
        ("world_left.enable:=true", "did you mean enabled?"),
        (f"{COLOR}.resolution_width:=1280", "found 1280x1080"),
    ],
)
def test_a_wrong_parameter_given_to_ros_ends_it(config: Path, given: str, said: str) -> None:
    command = ("-m", "ml2_receiver", "run", "--config", str(config), "--listen", "127.0.0.1:0")
    with Child(*command, "--ros-args", "-p", given) as child:
        assert child.wait() == 2
    assert any(said in line for line in child.errors), child.errors
    assert not any("Traceback" in line for line in child.errors)


def test_only_with_lazy_streams_without_subscribers_pause(
    client: Client, device: MockDevice
) -> None:
    with Subscriber("/magic_leap2/world_left/camera_info", "sensor_msgs/msg/CameraInfo") as first:
        while not first.has_line(0.1):
            device.publish("world_left/camera_info")
        assert client.ask("set", {"publish.lazy": True}) == [[True, ""]]
        asked = device.reconfigure()
        assert set(asked.streams) == {"world_left"}
        device.expect_start(asked.request)
        with Subscriber("/magic_leap2/color/metadata", "std_msgs/msg/String"):
            asked = device.reconfigure()
            assert set(asked.streams) == {"world_left", "color"}
            device.expect_start(asked.request)
        asked = device.reconfigure()
        assert set(asked.streams) == {"world_left"}
        device.expect_start(asked.request)
    assert device.reconfigure().streams == {}
    assert client.ask("set", {"publish.lazy": False}) == [[True, ""]]
    assert set(device.reconfigure().streams) == {"world_left", "color", "tf"}


MATCHED = """
import queue, rclpy
from pathlib import Path
from ml2_receiver.configuration.config import parse_config
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.ros.node import RosNode
from ml2_receiver.ros.sink import RosSink
from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.fan_out import FanOut

class Control:
    def __init__(self): self.demands = queue.Queue()
    def report(self): return None
    def paired(self): return None
    def demand(self, output, streams): self.demands.put(dict(streams))

def told(expected):  # one change may be told twice
    while (streams := control.demands.get()) != expected:
        pass
    return sorted(streams.items())

control, table = Control(), load_table()
config = parse_config(b"/**: {ros__parameters: {battery: {enabled: true}}}")
with RosNode(config, []) as node, RosSink(
    node, control, ConfigFile(Path("none")), lambda _: None, FanOut([])
) as sink:
    for stream in ("world_left", "battery"):
        sink.open(table.streams[stream].topics[0])
    print(told({"battery": False, "world_left": False}))
    rclpy.init()
    subscriber = rclpy.create_node("subscriber")
    from sensor_msgs.msg import BatteryState
    subscription = subscriber.create_subscription(BatteryState, "/magic_leap2/battery", print, 1)
    print(told({"battery": True, "world_left": False}))
    subscriber.destroy_subscription(subscription)
    print(told({"battery": False, "world_left": False}))
rclpy.shutdown()
"""


def test_the_middleware_tells_when_subscribers_come_and_go() -> None:
    with Child("-c", MATCHED) as child:
        assert child.line() == "[('battery', False), ('world_left', False)]"
        assert child.line() == "[('battery', True), ('world_left', False)]"
        assert child.line() == "[('battery', False), ('world_left', False)]"

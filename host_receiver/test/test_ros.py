"""The receiver's topics as other ROS processes see them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from configurations import only
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import Start, StreamStatus
from mock_device import MockDevice
from ros_messages import TYPES, header, mono_image
from ros_processes import Child, Client, Receiver, Subscriber

pytest.importorskip("rclpy", reason="rclpy is not installed")

IMAGE = "/magic_leap2/world_left/image_raw"
IMAGE_TYPE = "sensor_msgs/msg/Image"
STRING = "std_msgs/msg/String"
CONFIG = only("world_left: {enabled: true}, battery: {enabled: true}")


def image(number: int, width: int = 1016, height: int = 1016) -> bytes:
    """A payload of whole words, as DDS pads others to that on their way."""
    pixels = np.random.default_rng(number).integers(0, 256, (height, width), np.uint8)
    payload = mono_image(header("world_left_optical_frame", number), pixels)
    assert len(payload) % 4 == 0
    return payload


def publish_until_seen(device: MockDevice, subscriber: Subscriber) -> None:
    """Publishes until the subscriber hears it; messages before discovery are lost."""
    while not subscriber.has_line(0.1):
        device.publish("world_left/image_raw", image(0, 2, 2))
    device.publish("world_left/image_raw", image(1, 2, 2))
    while subscriber.message() != image(1, 2, 2):
        pass


def text(payload: bytes) -> str:
    return str(TYPES.deserialize_cdr(payload, STRING).data)  # type: ignore[attr-defined]


def test_payloads_arrive_at_another_process_byte_for_byte(device: MockDevice) -> None:
    with Subscriber(IMAGE, IMAGE_TYPE) as subscriber:
        assert subscriber.publisher == {
            "type": IMAGE_TYPE,
            "reliability": "RELIABLE",
            "durability": "VOLATILE",
        }
        publish_until_seen(device, subscriber)
        for number in (2, 3, 4):
            device.publish("world_left/image_raw", image(number))
            assert subscriber.message() == image(number)


def test_transforms_are_global(device: MockDevice) -> None:
    with Subscriber("/tf", "tf2_msgs/msg/TFMessage") as subscriber:
        assert subscriber.publisher["reliability"] == "RELIABLE"


def test_publishers_stay_over_sessions_unless_their_stream_does_not(device: MockDevice) -> None:
    with Subscriber(IMAGE, IMAGE_TYPE) as subscriber:
        publish_until_seen(device, subscriber)
        device.disconnect()
        device.start(refused={"battery": "empty"})
        device.publish("world_left/image_raw", image(7))
        assert subscriber.message() == image(7)
    with Subscriber("/magic_leap2/config", STRING, "transient_local") as subscriber:
        applied = json.loads(text(subscriber.message()))
        assert applied["streams"]["battery"] == {
            "result": "refused",
            "values": None,
            "reason": "empty",
            "topics": [],
            "state": {"state": "refused", "reason": "empty"},
        }
    camera = ("world_left/image_raw", "world_left/camera_info", "world_left/metadata")
    expected = {f"/magic_leap2/{name}" for name in ("config", "log", *camera)}
    assert topics_under("/magic_leap2/", expected) == expected


TOPICS = """
import sys, rclpy, json
rclpy.init()
node = rclpy.create_node("topics")

def published():
    return {name for name, _ in node.get_topic_names_and_types() if node.count_publishers(name)}

while not published().issuperset(sys.argv[1:]):
    rclpy.spin_once(node, timeout_sec=0.1)
for _ in range(5):
    rclpy.spin_once(node, timeout_sec=0.1)
print(json.dumps([*published()]))
"""


def topics_under(prefix: str, awaited: set[str]) -> set[str]:
    """Returns the topics that another node sees shortly after it sees the awaited ones."""
    with Child("-c", TOPICS, *awaited) as child:
        return {name for name in child.object() if name.startswith(prefix)}


def test_the_applied_configuration_is_there_for_who_comes_late(device: MockDevice) -> None:
    with Subscriber("/magic_leap2/config", STRING, "transient_local") as subscriber:
        assert subscriber.publisher["durability"] == "TRANSIENT_LOCAL"
        applied = json.loads(text(subscriber.message()))
    assert applied["headset"] == "device name"
    assert applied["session"] == device.welcome.session
    assert set(applied["streams"]) == {"world_left", "battery", "tf"}
    left = applied["streams"]["world_left"]
    assert (left["result"], left["values"]["update_rate"]) == ("applied", 30)
    assert left["topics"][0] == {
        "topic": IMAGE,
        "type": IMAGE_TYPE,
        "qos": "image",
        "role": "image",
    }
    assert applied["streams"]["tf"]["topics"][0]["topic"] == "/tf"


def test_events_are_logged_as_text(receiver: Receiver, device: MockDevice) -> None:
    with Subscriber("/magic_leap2/log", STRING) as subscriber:
        while not subscriber.has_line(0.1):
            device.disconnect()
            device.start()
        with MockDevice(receiver.address, "other") as other:
            other.greet().expect_error("busy")
        while "busy" not in text(subscriber.message()):
            pass
        device.leave()
        while "session ended" not in text(subscriber.message()):
            pass


def rows(payload: bytes) -> dict[str, Any]:
    array: Any = TYPES.deserialize_cdr(payload, "diagnostic_msgs/msg/DiagnosticArray")
    return {
        status.name.removeprefix("ml2_receiver: "): {
            "level": int(status.level),
            **{value.key: value.value for value in status.values},
        }
        for status in array.status
    }


def test_diagnostics_have_the_session_and_each_topic(device: MockDevice) -> None:
    with Subscriber("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray") as subscriber:
        assert rows(subscriber.message())["session"]["state"] == "connected"
        device.publish("world_left/image_raw")
        device.publish("world_left/image_raw", skip=2)
        device.leave()
        while (found := rows(subscriber.message()))["session"]["state"] != "ended":
            pass
    assert found["session"]["final"] == "true"
    assert found["clock"]["offset_ns"] == "-5"
    assert (found["security"]["level"], found["security"]["tls"]) == (1, "false")
    assert set(found) == {
        "session",
        "security",
        "clock",
        "/tf",
        "/magic_leap2/battery",
        *(f"/magic_leap2/world_left/{name}" for name in ("image_raw", "camera_info", "metadata")),
    }
    left = found[IMAGE]
    assert (left["level"], left["received"], left["gaps"]) == (1, "2", "2")
    assert (left["produced"], left["subscribers"]) == ("4", "0")


def test_what_gives_way_to_the_link_is_in_diagnostics_and_configuration(
    device: MockDevice,
) -> None:
    with (
        Subscriber("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray") as subscriber,
        Subscriber("/magic_leap2/config", STRING, "transient_local") as config,
    ):
        assert rows(subscriber.message())["adaptation"] == {"level": 0}
        assert stream_state(config.message(), "world_left") == {"state": "running"}
        lowered = StreamStatus("running", quality=60, rate_hz=15)
        device.status(streams={"world_left": lowered})
        while (found := rows(subscriber.message()))["adaptation"]["level"] == 0:
            pass
        told = {"state": "running", "quality": 60, "rate_hz": 15}
        assert stream_state(config.message(), "world_left") == told
        device.status()
        assert stream_state(config.message(), "world_left") == {"state": "running"}
    values = {"world_left.quality": "60", "world_left.rate_hz": "15"}
    assert found["adaptation"] == {"level": 1, **values}
    assert found[IMAGE]["expected_hz"] == "15"


def stream_state(payload: bytes, stream: str) -> Any:
    return json.loads(text(payload))["streams"][stream]["state"]


def test_a_link_test_is_asked_for_by_a_service_and_told_in_diagnostics(
    device: MockDevice, client: Client
) -> None:
    with Subscriber("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray") as subscriber:
        assert "link" not in rows(subscriber.message())
        accepted, words = client.ask("trigger", "test_link")
        assert (accepted, "row link" in words) == (True, True)
        assert client.ask("trigger", "test_link") == [False, "the link is being tested already"]
        device.expect_link_test()
        device.fill(1000)
        device.fill(1000)
        device.fill(0)
        while (found := rows(subscriber.message()).get("link", {})).get("state") != "measured":
            pass
    assert (found["level"], found["tests"], found["filler_bytes"]) == (0, "1", "2000")
    assert float(found["free_mbit_per_s"]) > 0
    assert float(found["streams_mbit_per_s"]) == 0


def test_a_service_starts_a_paused_receiver(config: Path) -> None:
    with (
        Receiver(config, "--start-paused") as receiver,
        MockDevice(receiver.address, says_ping=True) as device,
        Client() as client,
    ):
        request = device.configure()
        assert client.ask("trigger", "start")[0]
        assert Start.parse(device.wires["control"].expect(Kind.START)).request == request


def test_qos_can_be_overridden_at_start(config: Path) -> None:
    override = f"qos_overrides.{IMAGE}.publisher.reliability:=best_effort"
    with (
        Receiver(config, "--ros-args", "-p", override) as receiver,
        MockDevice(receiver.address, says_ping=True) as device,
    ):
        device.start()
        with Subscriber(IMAGE, IMAGE_TYPE) as subscriber:
            assert subscriber.publisher["reliability"] == "BEST_EFFORT"
        with Subscriber("/tf", "tf2_msgs/msg/TFMessage") as subscriber:
            assert subscriber.publisher["reliability"] == "RELIABLE"


def test_durability_can_be_overridden_and_what_changes_nothing_is_told(config: Path) -> None:
    given = {
        f"{IMAGE}.publisher.durability": "transient_local",
        f"{IMAGE}s.publisher.depth": "5",
        f"{IMAGE}.subscription.depth": "5",
        f"{IMAGE}.publisher.deadline": "5",
        "/magic_leap2/custom/joints.publisher.depth": "5",
    }
    options = [word for it in given.items() for word in ("-p", "qos_overrides.{}:={}".format(*it))]
    with (
        Receiver(config, "--ros-args", *options) as receiver,
        MockDevice(receiver.address, says_ping=True) as device,
    ):
        device.start()
        with Subscriber(IMAGE, IMAGE_TYPE) as subscriber:
            assert subscriber.publisher["durability"] == "TRANSIENT_LOCAL"
        told = [line for line in receiver.errors if "changes nothing" in line]
    assert len(told) == 3, receiver.errors
    assert f"did you mean {IMAGE}?" in told[0]
    assert "expected publisher, found subscription" in told[1]
    assert "expected one of depth, durability, history, reliability" in told[2]


def test_overrides_have_the_names_of_topics_after_remappings(config: Path) -> None:
    given = {
        "/robot1/tf.publisher.durability": "transient_local",
        "/tf.publisher.depth": "5",
        "/diagnostics.publisher.reliability": "best_effort",
    }
    options = [word for it in given.items() for word in ("-p", "qos_overrides.{}:={}".format(*it))]
    names = ("--name", "robot1", "--ros-args", "-r", "/tf:=tf")
    with (
        Receiver(config, *names, *options) as receiver,
        MockDevice(receiver.address, says_ping=True) as device,
    ):
        device.start()
        with Subscriber("/robot1/tf", "tf2_msgs/msg/TFMessage") as subscriber:
            assert subscriber.publisher["durability"] == "TRANSIENT_LOCAL"
        with Subscriber("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray") as subscriber:
            assert subscriber.publisher["reliability"] == "BEST_EFFORT"
        (told,) = [line for line in receiver.errors if "changes nothing" in line]
    assert "/tf.publisher.depth changes nothing: the topic is remapped to /robot1/tf" in told


@pytest.mark.parametrize(
    ("topic", "policy", "value", "said"),
    [
        (IMAGE, "reliability", "some", "expected one of system_default, reliable, best_effort"),
        ("/magic_leap2/config", "durability", "transient", "did you mean transient_local?"),
        ("/magic_leap2/log", "history", "keep_some", "expected one of system_default, keep_last"),
        ("/magic_leap2/log", "depth", "-1", "expected an integer of 1 to"),
        ("/magic_leap2/custom/joints", "depth", "many", "found 'many'"),
    ],
)
def test_a_policy_that_there_is_not_ends_it(
    config: Path, topic: str, policy: str, value: str, said: str
) -> None:
    override = f"qos_overrides.{topic}.publisher.{policy}"
    command = ("-m", "ml2_receiver", "run", "--config", str(config), "--listen", "127.0.0.1:0")
    with Child(*command, "--ros-args", "-p", f"{override}:={value}") as child:
        assert child.wait() == 2
    (told,) = [line for line in child.errors if override in line]
    assert told.startswith(f"ROS parameters: {override}: expected ")
    assert said in told


BOTH_WAYS = """
import rclpy
from std_msgs.msg import String
from rclpy.serialization import serialize_message
from ml2_receiver.ros.raw_publish import raw_publish, takes_bytearray

class Refusing:
    def publish_raw(self, payload): raise TypeError("bytes only")

class Publisher:
    handle = Refusing()

class Older:
    handle = object()

rclpy.init()
node = rclpy.create_node("both_ways")
publisher = node.create_publisher(String, "both_ways", 10)
got = []
node.create_subscription(String, "both_ways", lambda message: got.append(message.data), 10)
while not publisher.get_subscription_count():
    rclpy.spin_once(node, timeout_sec=0.1)
assert takes_bytearray(publisher, String(data="tried"))
assert not takes_bytearray(Publisher(), String())
assert not takes_bytearray(Older(), String())
for is_taken in (True, False):
    publish = raw_publish(publisher, is_taken)
    publish(bytearray(serialize_message(String(data=str(is_taken)))))
while len(got) < 3:
    rclpy.spin_once(node, timeout_sec=0.1)
print(got)
node.destroy_publisher(publisher)
publish(bytearray(4))
raw_publish(publisher, True)(bytearray(4))
print("ended topics take nothing")
"""


def test_payloads_are_published_whether_rclpy_takes_bytearrays_or_not() -> None:
    with Child("-c", BOTH_WAYS) as child:
        assert child.line() == "['tried', 'True', 'False']"
        assert child.line() == "ended topics take nothing"

"""`ml2-receiver run --zenoh`: beside ROS, without ROS, and with wrong input."""

import argparse
import contextlib
import itertools
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any
from unittest.mock import create_autospec

import pytest
import zenoh

import bag_scene
from command_line import refusal
from configurations import only
from fake_sink import FakeSink
from ml2_receiver.commands.zenoh_start import zenoh_output
from ml2_receiver.configuration.config import parse_config
from ml2_receiver.errors import ZenohError
from ml2_receiver.session.demand import STAYS_S
from ml2_receiver.topics.control import ReceiverControl
from ml2_receiver.topics.fan_out import FanOut
from ml2_receiver.wire.kinds import Kind
from ml2_receiver.wire.messages import Configure
from ml2_receiver.zenoh.configuration import session_configuration
from mock_device import MockDevice
from ros_messages import TYPES
from ros_processes import Child, Receiver, Subscriber, environment
from waiting import LIMIT_S, await_true
from zenoh_peers import open_router

CONFIG = only("world_left: {enabled: true}, battery: {enabled: true}")
# Runs the command where Python finds nothing of ROS.
WITHOUT_ROS = """
import sys
class NoRos:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0].endswith(("_msgs", "_srvs", "_interfaces")) or name in (
            "rclpy", "rosidl_parser"):
            raise ModuleNotFoundError(f"{name} was imported", name=name)
sys.meta_path.insert(0, NoRos())
from ml2_receiver.cli import main
sys.exit(main(sys.argv[1:]))
"""
LISTEN = ("--listen", "127.0.0.1:0", "--insecure")


def key(name: str) -> str:
    return f"{environment()['ROS_DOMAIN_ID']}/{name}/*/*"


def await_sample(samples: "SimpleQueue[zenoh.Sample]", send: Any) -> bytes:
    """Sends until a sample comes: what is sent before its subscriber is known goes nowhere."""
    for number in itertools.count():
        send(number)
        with contextlib.suppress(Empty):
            return samples.get(timeout=0.1).payload.to_bytes()
    raise AssertionError


def without_ros(config: Path, endpoint: str, *options: str) -> Child:
    given = ("--config", str(config), *LISTEN, "--no-ros", "--zenoh", endpoint)
    return Child("-c", WITHOUT_ROS, "run", *given, *options)


def beside_ros(config: Path, endpoint: str, *options: str) -> Receiver:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    return Receiver(config, "--zenoh", endpoint, *options)


@contextlib.contextmanager
def streaming(config: Path, endpoint: str, *options: str) -> Iterator[MockDevice]:
    """A device that streams to a receiver beside ROS, which has found the router."""
    with beside_ros(config, endpoint, *options) as receiver:
        receiver.await_error(f"Zenoh: connected to {endpoint}")
        with MockDevice(receiver.address, says_ping=True) as device:
            device.start()
            yield device


def test_without_ros_all_topics_and_diagnostics_are_on_zenoh(
    config: Path, endpoint: str, router: zenoh.Session
) -> None:
    images: SimpleQueue[zenoh.Sample] = SimpleQueue()
    statuses: SimpleQueue[zenoh.Sample] = SimpleQueue()
    router.declare_subscriber(key("magic_leap2/world_left/image_raw"), images.put)
    router.declare_subscriber(key("diagnostics"), statuses.put)
    with without_ros(config, endpoint) as receiver:
        address = receiver.line().removeprefix("listening on ")
        receiver.await_error(f"Zenoh: connected to {endpoint}")
        with MockDevice(address, says_ping=True) as device:
            device.start()
            image = await_sample(
                images, lambda it: device.publish("world_left/image_raw", bag_scene.image(it))
            )
            assert image[4:] in {bag_scene.image(number)[4:] for number in range(100)}

            def names() -> set[str]:
                payload = statuses.get(timeout=LIMIT_S).payload.to_bytes()
                array: Any = TYPES.deserialize_cdr(payload, "diagnostic_msgs/msg/DiagnosticArray")
                return {status.name for status in array.status}

            await_true(lambda: "ml2_receiver: /magic_leap2/world_left/image_raw" in names())
            assert "ml2_receiver: session" in names()
            device.leave()
        assert receiver.end(signal.SIGTERM) == 0


def test_beside_ros_both_get_the_same_bytes(
    config: Path, endpoint: str, router: zenoh.Session
) -> None:
    samples: SimpleQueue[zenoh.Sample] = SimpleQueue()
    router.declare_subscriber(key("magic_leap2/battery"), samples.put)
    with streaming(config, endpoint) as device:
        with Subscriber("/magic_leap2/battery", "sensor_msgs/msg/BatteryState") as subscriber:
            for number in itertools.count():
                device.publish("battery", bag_scene.battery(number))
                if subscriber.has_line(0.1):
                    break
            last = bag_scene.battery(5000)
            device.publish("battery", last)
            await_true(lambda: subscriber.message().startswith(last))  # DDS pads to 4 bytes
        await_true(lambda: samples.get(timeout=LIMIT_S).payload.to_bytes() == last)


def test_remapped_topics_are_remapped_on_zenoh_too(
    config: Path, endpoint: str, router: zenoh.Session
) -> None:
    samples: SimpleQueue[zenoh.Sample] = SimpleQueue()
    router.declare_subscriber(key("robot1/charge"), samples.put)
    remapping = ("--ros-args", "-r", "/robot1/magic_leap2/battery:=charge")
    with streaming(config, endpoint, "--name", "robot1", *remapping) as device:
        sent = bag_scene.battery(5)
        assert await_sample(samples, lambda _: device.publish("battery", sent)) == sent


@pytest.mark.parametrize("start", [beside_ros, without_ros])
def test_a_renamed_node_has_its_name_in_the_graph_of_zenoh(
    config: Path, endpoint: str, router: zenoh.Session, start: Callable[..., Child]
) -> None:
    node = ("-r", "__node:=headset", "-r", "__ns:=/robot1")
    with start(config, endpoint, "--ros-args", *node) as receiver:
        receiver.await_error(f"Zenoh: connected to {endpoint}")

        def names() -> set[tuple[str, ...]]:
            tokens = router.liveliness().get("@ros2_lv/**")
            return {tuple(str(it.ok.key_expr).split("/")[7:9]) for it in tokens if it.ok}

        await_true(lambda: bool(names()))  # the router learns of them after the connection
        assert names() == {("%robot1", "headset")}


@contextlib.contextmanager
def resting(config: Path, endpoint: str) -> Iterator[MockDevice]:
    """A device of which a lazy receiver without ROS wants nothing at present."""
    config.write_text(f"{CONFIG}    publish: {{lazy: true}}\n")
    with without_ros(config, endpoint) as receiver:
        address = receiver.line().removeprefix("listening on ")
        receiver.await_error(f"Zenoh: connected to {endpoint}")
        with MockDevice(address, says_ping=True) as device:
            device.configure()
            await_streams(device)
            yield device


def await_streams(device: MockDevice, *expected: str) -> Configure:
    """The CONFIGURE with these streams; Zenoh tells of one topic after another."""
    while set((asked := device.reconfigure()).streams) != {*expected}:
        pass
    return asked


def test_only_with_lazy_streams_without_subscribers_on_zenoh_pause(
    config: Path, endpoint: str, router: zenoh.Session
) -> None:
    with resting(config, endpoint) as device:
        subscriber = router.declare_subscriber(key("magic_leap2/battery"), lambda _: None)
        asked = await_streams(device, "battery")
        device.expect_start(asked.request)
        subscriber.undeclare()
        await_streams(device)


def test_a_subscriber_in_a_loop_has_a_camera_configured_seldom(
    config: Path, endpoint: str, router: zenoh.Session
) -> None:
    with resting(config, endpoint) as device:
        began_s = time.monotonic()
        with ThreadPoolExecutor(1) as other:
            other.submit(come_and_go, router, "world_left/image_raw", "battery")
            asked: list[Configure] = []
            while not any("battery" in it.streams for it in asked):
                frame = device.wires["control"].receive()
                assert frame is not None
                if frame.header.kind == Kind.CONFIGURE:
                    asked.append(Configure.parse(frame.body))
                    device.answer(asked[-1])
        took_s = time.monotonic() - began_s
    assert any("world_left" in it.streams for it in asked)
    # A start and an end in each of these times, and what the battery asks for.
    assert len(asked) <= 2 * (1 + took_s / STAYS_S) + 1


def come_and_go(router: zenoh.Session, topic: str, last: str) -> None:
    """Subscribes to a topic again and again, and then to the last one."""
    for _ in range(96):
        subscriber = router.declare_subscriber(key(f"magic_leap2/{topic}"), lambda _: None)
        time.sleep(0.03)  # it stays for so long
        subscriber.undeclare()
        time.sleep(0.03)
    router.declare_subscriber(key(f"magic_leap2/{last}"), lambda _: None)


def test_a_router_that_is_not_there_is_said_and_tried_again(config: Path, endpoint: str) -> None:
    with without_ros(config, endpoint) as receiver:
        receiver.await_error(f"Zenoh: {endpoint} is not reached: Connection refused; trying again")
        with open_router(endpoint):
            receiver.await_error(f"Zenoh: connected to {endpoint}")
        await_true(lambda: sum("Connection refused" in it for it in receiver.errors) == 2)
        with open_router(endpoint):
            await_true(lambda: sum("connected to" in it for it in receiver.errors) == 2)
        assert receiver.end() == 0


def test_it_ends_at_once_while_there_is_no_router(config: Path, endpoint: str) -> None:
    with without_ros(config, endpoint) as receiver:
        receiver.await_error("is not reached")
        assert receiver.end() == 0


@pytest.mark.parametrize(
    "address", ["127.0.0.1:7447", "router", "tcp/router", "tcp/:7447", "tcp/router:0", ""]
)
def test_an_endpoint_has_protocol_host_and_port(address: str) -> None:
    error = refusal("run", "--no-ros", "--zenoh", address).splitlines()[-1]
    expected = "expected PROTOCOL/HOST:PORT, such as tcp/192.168.1.5:7447"
    assert error.endswith(f"argument --zenoh: {expected}, found {address!r}")


def test_a_key_in_an_endpoint_is_not_repeated() -> None:
    for address in ("tls/router#root=SECRET", "tls/router:0?a=b#root=SECRET"):
        assert "SECRET" not in refusal("run", "--no-ros", "--zenoh", address)
    with pytest.raises(ZenohError) as refused:
        session_configuration("tls/router:1#=;=SECRET", None)
    assert "SECRET" not in str(refused.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, "{} cannot be read: No such file or directory"),
        ("{mode: ", "{} is no configuration of Zenoh: line 1, column 8: expected "),
        ("{mood: 1}", "{} is no configuration of Zenoh: unknown field `mood`, expected one of "),
    ],
)
def test_a_wrong_configuration_of_zenoh_ends_it(
    tmp_path: Path, config: Path, content: str | None, said: str
) -> None:
    file = tmp_path / "zenoh.json5"
    if content is not None:
        file.write_text(content)
    options = ("--no-ros", "--zenoh", "tcp/127.0.0.1:1", "--zenoh-config", file)
    told = refusal("run", "--config", config, *LISTEN, *options).splitlines()
    lines = [it for it in told if "WARNING" not in it]
    assert lines[0].startswith(said.format(file))
    assert lines[1].startswith("hint: ")
    assert len(lines) == 2


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--no-ros"], "--no-ros needs --zenoh"),
        (["--zenoh-config", "zenoh.json5"], "--zenoh-config needs --zenoh"),
        (["--no-ros", "--view", "--zenoh", "tcp/a:1"], "--view shows topics of ROS 2"),
        (["--no-ros", "--start-paused", "--zenoh", "tcp/a:1"], "--start-paused waits for"),
    ],
)
def test_options_that_do_not_fit_end_it(options: list[str], said: str) -> None:
    assert refusal("run", *options).startswith(said)


@pytest.mark.parametrize("name", ["rmw_zenoh_cpp", "rmw_zenoh_pico"])
def test_a_node_on_zenoh_is_not_published_there_twice(
    config: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv("RMW_IMPLEMENTATION", name)
    error = refusal("run", "--config", config, *LISTEN, "--zenoh", "tcp/10.0.0.1:7447#key=SECRET")
    assert f"on Zenoh ({name}): with --zenoh, all would be published twice" in error
    assert "ZENOH_CONFIG_OVERRIDE='connect/endpoints=[\"tcp/10.0.0.1:7447\"]'" in error
    assert "--no-ros" in error
    assert "SECRET" not in error


def test_a_ros_whose_default_is_zenoh_is_found_out(
    config: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rclpy = pytest.importorskip("rclpy", reason="rclpy is not installed")
    monkeypatch.delenv("RMW_IMPLEMENTATION", raising=False)
    monkeypatch.setattr(
        rclpy.utilities, "get_rmw_implementation_identifier", lambda: "rmw_zenoh_cpp"
    )
    error = refusal("run", "--config", config, *LISTEN, "--zenoh", "tcp/127.0.0.1:1")
    assert "all would be published twice" in error


def test_without_a_node_the_middleware_of_ros_does_not_matter(
    config: Path, endpoint: str, router: zenoh.Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")
    with without_ros(config, endpoint) as receiver:
        receiver.await_error(f"Zenoh: connected to {endpoint}")
        assert receiver.end() == 0


@pytest.mark.parametrize(
    ("endpoint", "is_warned"),
    [
        ("tcp/192.0.2.1:7447#iface=lo", True),
        ("udp/router:7447", True),
        ("tls/192.0.2.1:7447", False),
        ("quic/router:7447", False),
        ("tcp/127.0.0.1:7447", False),
        ("tcp/[::1]:7447", False),
        ("tcp/localhost:7447", False),
        ("tcp/localhost.example.com:7447", True),
    ],
)
def test_plaintext_to_another_machine_is_warned_of(
    capsys: pytest.CaptureFixture[str], endpoint: str, is_warned: bool
) -> None:
    options = argparse.Namespace(zenoh=endpoint, zenoh_config=None)
    sinks, control = FanOut([FakeSink()]), create_autospec(ReceiverControl)
    zenoh_output(options, parse_config(CONFIG.encode()), sinks, control, "it")
    error = capsys.readouterr().err
    assert (f"WARNING: {endpoint.partition('#')[0]}: no encryption" in error) == is_warned
    assert "iface" not in error


@pytest.mark.parametrize(("module", "package"), [("zenoh", "eclipse-zenoh"), ("xxhash", "xxhash")])
def test_a_missing_package_is_named_with_the_command_that_installs_it(
    config: Path, monkeypatch: pytest.MonkeyPatch, module: str, package: str
) -> None:
    for name in [it for it in sys.modules if it.startswith("ml2_receiver.zenoh")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    options = ["--no-ros", "--zenoh", "tcp/127.0.0.1:1"]
    error = refusal("run", "--config", config, *LISTEN, *options)
    assert f"--zenoh needs the package {package}, which is not installed" in error
    assert "hint: Run in the clone `pip install './host_receiver[zenoh]'`." in error


def test_a_domain_that_there_is_not_ends_it(config: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(os.environ, "ROS_DOMAIN_ID", "seven")
    options = ["--no-ros", "--zenoh", "tcp/127.0.0.1:1"]
    assert "expected a ROS_DOMAIN_ID from 0 to 232, found 'seven'" in refusal(
        "run", "--config", config, *LISTEN, *options
    )

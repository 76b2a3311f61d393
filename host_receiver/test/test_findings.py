import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from free_port import reserve_port
from ml2_receiver.processes import Process, is_listened_on, is_receiver, listener_of
from ml2_receiver.processes import processes as all_processes
from ml2_receiver.ros.fastdds import PROFILES_VARIABLE
from ml2_receiver.transport.discovery import FoundReceiver
from ml2_tools.doctor import findings

RECEIVER = Process(12, "python3", ("python3", "-P", "-m", "ml2_receiver", "run"))
OTHER = Process(13, "nginx", ("nginx",))


@pytest.mark.parametrize(
    ("found", "level", "fix"),
    [
        (findings.python((3, 12, 3)), "ok", ""),
        (findings.python((3, 10, 12)), "wrong", "Python 3.12"),
        (findings.ros("jazzy", []), "ok", ""),
        (findings.ros(None, []), "ok", ""),
        (findings.ros("jazzy", ["rclpy"]), "wrong", "source /opt/ros/jazzy/setup.bash"),
        (findings.ros("humble", []), "wrong", "only Jazzy"),
        (findings.shared_memory(64_000_000), "wrong", "--shm-size"),
        (findings.shared_memory(80_000_000), "ok", ""),
        (findings.udp_buffer(212_992), "hint", "sysctl -w net.core.rmem_max=4194304"),
        (findings.udp_buffer(None), "hint", "sysctl"),
        (findings.udp_buffer(4_194_304), "ok", ""),
        (findings.port(7755, None, is_listened_on=False), "ok", ""),
        (findings.port(7755, RECEIVER, is_listened_on=True), "ok", ""),
        (findings.port(7755, OTHER, is_listened_on=True), "wrong", "--listen"),
        (findings.port(7755, None, is_listened_on=True), "wrong", "--listen"),
        (findings.firewall(None, 7755), "ok", ""),
        (findings.firewall("ufw", 7755), "hint", "sudo ufw allow 7755/tcp"),
        (findings.firewall("firewalld", 7755), "hint", "--add-port=7755/tcp"),
        (findings.multicast([]), "ok", ""),
        (findings.multicast("no multicast: x"), "wrong", "the address"),
        (findings.clock(True), "ok", ""),
        (findings.clock(False), "hint", "timedatectl"),
        (findings.domain("5", {12: "5"}), "ok", ""),
        (findings.domain(None, {12: "0"}), "ok", ""),
        (findings.domain("5", {11: "4", 12: "5"}), "ok", ""),
        (findings.domain(None, {12: "5"}), "wrong", "export ROS_DOMAIN_ID=5"),
        (findings.domain("5", {12: None}), "wrong", "export ROS_DOMAIN_ID=0"),
        (findings.parameter_file("a.yaml", ["/ml2_receiver"]), "ok", ""),
        (findings.parameter_file("a.yaml", ["/**"]), "ok", ""),
        (findings.parameter_file("a.yaml", ["/camera", "/robot1/ml2_receiver"]), "ok", ""),
        (findings.parameter_file("a.yaml", ["config_ML_node"]), "hint", "run --config a.yaml"),
    ],
)
def test_each_finding_has_its_level_and_its_fix(
    found: findings.Finding, level: str, fix: str
) -> None:
    assert found.level == level
    assert fix in found.fix
    assert bool(found.fix) == (level != "ok")


@pytest.mark.parametrize(
    ("environment", "is_in_working_directory", "level"),
    [
        ({}, False, "ok"),
        ({PROFILES_VARIABLE: "mine.xml"}, False, "hint"),
        ({}, True, "hint"),
        ({"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}, False, "hint"),
        ({"RMW_IMPLEMENTATION": "rmw_zenoh_cpp"}, False, "ok"),
    ],
)
def test_a_profile_of_the_user_is_named(
    environment: dict[str, str], is_in_working_directory: bool, level: str
) -> None:
    found = findings.fast_dds_profile(environment, is_in_working_directory=is_in_working_directory)
    assert found.level == level
    for name in environment.values():
        assert name in found.found


def test_who_has_the_port_is_named() -> None:
    assert "nginx (pid 13)" in findings.port(7755, OTHER, is_listened_on=True).found
    assert "another user" in findings.port(7755, None, is_listened_on=True).found


def test_found_receivers_are_named() -> None:
    found = findings.multicast([FoundReceiver("desk", ("192.168.1.5",), 7755)])
    assert found.found == "desk at 192.168.1.5, port 7755"


def test_streams_that_are_enabled_and_do_not_run_are_wrong() -> None:
    camera = "android.permission.CAMERA"
    session = {
        "state": "connected",
        "state.world_left": "waiting: taken away",
        "missing.world_left": camera,
        "state.battery": "running",
    }
    finding = findings.streams({"session": session})
    assert finding is not None
    assert (finding.level, finding.found) == ("wrong", "world_left: waiting: taken away")
    assert finding.fix == f"grant {camera}, by `ml2-receiver headset grant world_left`"


def test_a_silent_stream_is_wrong() -> None:
    text = "silent: nothing has come for 3 s, expected 5 Hz"
    session = {"state": "connected", "state.depth": text, "state.color": "paused"}
    finding = findings.streams({"session": session})
    assert finding is not None
    assert (finding.level, finding.found) == ("wrong", f"depth: {text}")
    assert finding.fix


def test_streams_that_run_are_well() -> None:
    finding = findings.streams({"session": {"state": "connected", "state.depth": "running"}})
    assert finding is not None
    assert finding.level == "ok"
    assert findings.streams({"session": {"state": "lost"}}) is None


@pytest.mark.parametrize(
    ("command", "is_one"),
    [
        (("python3", "-P", "-m", "ml2_receiver", "run", "--config", "a"), True),
        (("/usr/bin/python3", "/opt/bin/ml2-receiver", "run"), True),
        (("python3", "-m", "ml2_receiver", "doctor"), False),
        (("less", "run"), False),
        ((), False),
    ],
)
def test_a_receiver_is_known_by_its_command(command: tuple[str, ...], is_one: bool) -> None:
    assert is_receiver(command) is is_one


def test_a_process_of_ours_has_the_name_that_was_typed() -> None:
    ours = ("python3", "-P", "-m", "ml2_receiver", "record", "walk")
    assert str(Process(7, "python3", ours)) == "ml2-receiver (pid 7)"
    assert str(Process(7, "python3", ("python3", "other.py"))) == "python3 (pid 7)"


@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_the_process_that_listens_is_found(host: str) -> None:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    port = reserve_port()
    with socket.create_server((host, port), family=family):
        assert is_listened_on(port)
        holder = listener_of(port)
        assert holder is not None
        assert holder.pid == os.getpid()
        assert holder.name == Path("/proc/self/comm").read_text().strip()
    assert not is_listened_on(port)
    assert listener_of(port) is None


def test_a_process_tells_its_environment() -> None:
    with subprocess.Popen(
        [sys.executable, "-c", "input()"], stdin=subprocess.PIPE, env={"ROS_DOMAIN_ID": "42"}
    ) as child:
        process = next(it for it in all_processes() if it.pid == child.pid)
        assert process.environment("ROS_DOMAIN_ID") == "42"
        assert process.environment("ROS_DISTRO") is None
        child.communicate()

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from ml2_receiver.doctor import findings
from ml2_receiver.processes import Process, is_listened_on, is_receiver, listener_of
from ml2_receiver.processes import processes as all_processes
from ml2_receiver.ros.fastdds import PROFILES_VARIABLE
from ml2_receiver.transport.discovery import FoundReceiver

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


SESSION = {"state": "connected"}
IMAGE_ROW = {
    "rate_hz": "29.04",
    "expected_hz": "30",
    "mbit_per_s": "242.0",
    "latency_p99_ms": "12.5",
}
IMU_ROW = {"rate_hz": "200.0", "mbit_per_s": "0.5"}
PAUSED_ROW = {"rate_hz": "0.00", "expected_hz": "30", "mbit_per_s": "0.00"}
ROWS = {"session": SESSION, "/a": IMAGE_ROW, "/b": IMU_ROW, "/c": PAUSED_ROW}


def tried(free: float, streams: float) -> dict[str, str]:
    rates = {"free_mbit_per_s": f"{free}", "streams_mbit_per_s": f"{streams}"}
    return {"state": "measured", "filler_bytes": "67108864", "duration_s": "1.3", **rates}


@pytest.mark.parametrize(
    ("rows", "found"),
    [
        ("no receiver runs here", "not measured: no receiver runs here"),
        ({"session": {"state": "waiting"}}, "not measured: the session is waiting"),
    ],
)
def test_without_a_headset_no_link_is_measured(
    rows: dict[str, dict[str, str]] | str, found: str
) -> None:
    finding = findings.link(rows, "")
    assert (finding.level, finding.found, finding.numbers) == ("hint", found, {})


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


def test_a_link_that_carries_more_than_its_streams_need_is_well() -> None:
    finding = findings.link(ROWS, tried(412.0, 240.0))
    assert (finding.level, finding.fix) == ("ok", "")
    assert finding.found == (
        "242.5 Mbit/s arrive, p99 of the slowest topic 12.5 ms; in a test 412.0 Mbit/s were free"
        " besides 240.0 of the streams, which need 250.5"
    )
    assert finding.numbers == pytest.approx(
        {
            "arriving_mbit_per_s": 242.5,
            "needed_mbit_per_s": 250.5,
            "slowest_p99_ms": 12.5,
            "dropped": 0,
            "free_mbit_per_s": 412.0,
            "streams_mbit_per_s": 240.0,
            "filler_bytes": 67108864,
            "duration_s": 1.3,
        }
    )


def test_a_link_that_carries_too_little_has_a_fix() -> None:
    finding = findings.link(ROWS, tried(100.0, 150.0))
    assert finding.level == "hint"
    for remedy in ("5 or 6 GHz", "cable", "update_rate", "JPEG"):
        assert remedy in finding.fix


@pytest.mark.parametrize(
    ("test", "fix"),
    [
        (tried(100.0, 150.0), "cable"),
        ("the headset does not answer", "cable"),
        (tried(900.0, 250.0), "whether this machine is busy"),
    ],
)
def test_full_queues_are_a_hint_however_much_is_free(test: dict[str, str] | str, fix: str) -> None:
    rows = ROWS | {"/a": IMAGE_ROW | {"dropped.queue_full": "7"}}
    finding = findings.link(rows, test)
    assert (finding.level, fix in finding.fix) == ("hint", True)
    assert "; 7 messages were dropped as the link or this machine was too slow" in finding.found


@pytest.mark.parametrize(
    ("test", "why"),
    [
        ("the headset does not answer", "the headset does not answer"),
        ({"state": "unanswered", "message": "link test: unanswered"}, "link test: unanswered"),
    ],
)
def test_a_link_that_was_not_tried_is_no_more_than_what_arrives(
    test: dict[str, str] | str, why: str
) -> None:
    finding = findings.link(ROWS, test)
    assert finding.level == "hint"
    assert finding.found.endswith(f"; what more it carries is not known: {why}")
    assert set(finding.numbers) == {
        "arriving_mbit_per_s",
        "needed_mbit_per_s",
        "slowest_p99_ms",
        "dropped",
    }


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


@pytest.mark.parametrize("host", ["127.0.0.1", "::1"])
def test_the_process_that_listens_is_found(host: str) -> None:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.create_server((host, 0), family=family) as server:
        port = server.getsockname()[1]
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

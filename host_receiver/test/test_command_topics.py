import io
import json
import re
import signal
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from configurations import only
from ml2_receiver.wire.messages import StreamStatus
from ml2_tools.monitoring.topic_table import topic_table
from mock_device import MockDevice
from repeated import repeated
from ros_processes import Child, Receiver
from terminal import OnTerminal, plain

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("battery: {enabled: true}, world_left: {enabled: true}")
BATTERY = "/magic_leap2/battery"
IMAGE = "/magic_leap2/world_left/image_raw"
WAITING = "waiting: no message has come yet"
SILENT = r"silent: nothing has come for \d+ s,.*"


def command(*arguments: str) -> Child:
    return Child("-m", "ml2_receiver", *arguments)


def printed(child: Child) -> Any:
    """All of its standard output, which is JSON."""
    text = ""
    while True:
        text += child.line()
        try:
            return json.loads(text)
        except json.JSONDecodeError:
            continue


def test_topics_have_their_counts_rates_and_losses(device: MockDevice) -> None:
    for skip in (0, 2, 0):
        device.publish("battery", skip=skip)
    device.exchange_time(1)
    with command("topics", "--json") as child:
        topics = {each["topic"]: each for each in printed(child)}
        assert child.wait() == 0
    assert topics[BATTERY]["received"] == 3
    assert topics[BATTERY]["lost"] == 2
    assert topics[BATTERY]["expected_hz"] is None
    assert topics[BATTERY]["subscribers"] == 0
    assert (topics[BATTERY]["stream"], topics[BATTERY]["stream_state"]) == ("battery", "running")
    camera = topics[IMAGE]
    assert (camera["expected_hz"], camera["received"]) == (30, 0)
    # On a busy machine the camera may be silent by then
    assert camera["stream_state"] in ("waiting", "silent")
    assert re.fullmatch(f"{WAITING}|{SILENT}", camera["state"])


def test_the_table_has_an_expected_rate_or_as_delivered(device: MockDevice) -> None:
    with command("topics", "--once") as child:
        rows = {topic: line_with(child, f" {topic} ") for topic in (IMAGE, BATTERY)}
    assert "30" in rows[IMAGE].split()
    assert "as delivered" in rows[BATTERY]
    assert rows[BATTERY].rstrip().endswith(WAITING)
    assert re.search(rf"({WAITING}|{SILENT})\s*$", rows[IMAGE])


def test_80_columns_have_rate_losses_and_latency(device: MockDevice) -> None:
    device.exchange_time(1)
    for skip in (0, 2):
        device.publish("battery", skip=skip)
    image = "world_left/image_raw"  # again and again, for it is not to be silent
    with (
        repeated(lambda: device.publish(image), 0.03),
        OnTerminal("topics", "--once") as child,
    ):
        head = r"topics under\s+/magic_leap2/.*Hz +lost +ms +ms +state"
        whole = r"\n  world_left/image_raw +[\d.]+ +30 +0 +[\d.]+ +[\d.]+ +✓ "
        lossy = r"\n  battery +[\d.]+ +as delivered +2 +[\d.]+ +[\d.]+ +lost "
        shown = child.await_shown(f"(?s){head}.*{whole}.*{lossy}".encode())
    assert max(len(it.rstrip()) for it in plain(shown).splitlines()) <= 80


def test_a_wide_table_says_why_messages_were_lost() -> None:
    lost = {"message": "lost messages: 3", "dropped.queue_full": "3", "dropped.no_buffer": "0"}
    console = Console(width=150, file=io.StringIO(), record=True)
    console.print(topic_table({BATTERY: {"type": "sensor_msgs/msg/BatteryState"} | lost}, console))
    assert re.search(r"battery.* lost: queue_full +\n", console.export_text())


def line_with(child: Child, words: str) -> str:
    while words not in (line := child.line()):
        pass
    return line


def test_the_live_table_ends_with_an_interrupt(device: MockDevice) -> None:
    with command("topics") as child:
        assert child.line() == "watching until Ctrl-C"
        child.process.send_signal(signal.SIGINT)
        while BATTERY not in child.line():
            pass
        assert child.wait() == 0


def test_devices_tell_why_a_stream_does_not_run(receiver: Receiver) -> None:
    with MockDevice(receiver.address, says_ping=True) as device:
        device.start(refused={"world_left": "covered: by a sticker"})
        device.publish("battery")
        with command("devices", "--json") as child:
            headset: Any = printed(child)
            assert child.wait() == 0
    assert (headset["name"], headset["state"]) == ("device name", "connected")
    streams = {each["stream"]: each for each in headset["streams"]}
    assert streams["battery"]["state"] == "runs"
    assert streams["world_left"]["state"] == "unavailable"
    assert streams["world_left"]["reason"] == "covered: by a sticker"


def test_devices_tell_what_is_lowered_in_the_words_of_diagnostics(
    device: MockDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    device.status(streams={"world_left": StreamStatus("running", quality=60, rate_hz=15)})
    with command("devices") as child:
        row = line_with(child, "world_left")
        assert "lowered for the link" not in line_with(child, "battery")
        assert child.wait() == 0
    with command("devices", "--json") as child:
        lowered = {it["stream"]: it["lowered"] for it in printed(child)["streams"]}
    assert row.rstrip().endswith(" lowered for the link: quality 60, 15 Hz")
    assert (lowered["world_left"], lowered["battery"]) == ("quality 60, 15 Hz", "")


def test_doctor_tells_what_the_link_carries(device: MockDevice) -> None:
    device.publish("battery")
    with command("doctor", "--json") as child:
        found = {each["check"]: each for each in printed(child)}
    assert "Mbit/s arrive, p99 of the slowest topic" in found["link to headset"]["found"]


@pytest.mark.parametrize("folder", ["missing/log", "read_only"])
def test_where_ros_cannot_write_its_log_it_names_the_variable_to_set(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str
) -> None:
    (tmp_path / "missing").touch()  # no folder can be made in a file
    (tmp_path / "read_only").symlink_to("/proc/1/task")  # in which nobody makes files
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / folder))
    with command("topics", "--once") as child:
        assert child.wait() == 2
    error, hint = child.errors
    assert error == f"ROS 2 cannot write its log to {tmp_path / folder}"
    assert "ROS_LOG_DIR" in hint

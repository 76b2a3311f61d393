"""Measures what `ml2-receiver view` costs while a client is shown all that there is.

Usage: view_bench.py DURATION, in seconds. Writes build/bench/view.json:

cpu_percent     the process of `view`, in percent of one processor
rss_mb          its memory at the end
memory_mb_per_hour the slope of its memory without files
threads_grown   how many more threads it has at the end than at the beginning
files_grown     the same of open files
imu_p99_ms      from capture to `ml2-receiver latency` for 30 s at most, without and with `view`
latency_p50_ms  from capture to the client, of images of the RGB camera
images_per_s    images of all cameras that the client got
receiver_drops  messages of all topics that the receiver lost meanwhile
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from contextlib import ExitStack
from pathlib import Path

from rclpy.qos import qos_profile_sensor_data

from load_run import Usage, growth
from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from ml2_receiver.topics.stamps import stamp_reader
from ml2_tools.bags.decoding import decoder
from ml2_tools.live.diagnostics_node import DiagnosticsNode
from ml2_tools.live.faults import Faults
from ml2_tools.monitoring.topic_table import topic_figures
from processes import (
    PREFIX,
    RECEIVER,
    headset_command,
    isolated_environment,
    line_with,
    listening_address,
    process,
    receive_command,
)
from simulation import compressed_config
from viewing_browser import Browser

RESULTS = Path(__file__).resolve().parents[2] / "build" / "bench" / "view.json"
_COLOR, _TYPE = f"{PREFIX}/color/image_raw/compressed", "sensor_msgs/msg/CompressedImage"
_IMU = "gyro_left/imu"
_WARM_UP_S = 5.0
_LATENCY_S = 30.0
_TIMEOUT_S = 60.0


class Client:
    """Shows everything, and notes when images come.

    Attributes:
        images: when each image came, by time.time_ns().
        color: the JPEGs of the RGB camera, which come as they were sent, with their times.
    """

    def __init__(self, address: str) -> None:
        url, _, token = address.partition("/#")
        self.images: list[int] = []
        self.color: list[tuple[int, int]] = []
        self._browser = Browser(url, token)
        streams = self._browser.text("hello")["images"]
        self._browser.say(show=[*streams, "scene", "cloud"])

    def take(self) -> None:
        """Takes one message."""
        message = self._browser.connection.recv(_TIMEOUT_S)
        now_ns = time.time_ns()
        if isinstance(message, str):
            found = json.loads(message)
            if found["type"] not in ("hello", "answer"):
                self._browser.say(seen=found.get("stream", found["type"]))
            return
        end = 1 + message[0]
        name = message[1:end].decode()
        self._browser.say(seen=name)
        if name != "cloud":
            self.images.append(now_ns)
        if name == "color":
            self.color.append((hash(message[end + 4 :]), now_ns))


class Stamps:
    """The captures of the RGB camera by the hash of their JPEG; a subscriber beside the page."""

    def __init__(self) -> None:
        self._by_jpeg: defaultdict[int, list[int]] = defaultdict(list)
        self._read = stamp_reader(_TYPE)
        self._decode = decoder(_TYPE)

    def subscription(self) -> RawSubscription:
        return RawSubscription(_TYPE, _COLOR, qos_profile_sensor_data, self._take)

    def _take(self, payload: bytes) -> None:
        self._by_jpeg[hash(bytes(self._decode(payload).data))].append(self._read(payload))

    def latency_ms(self, jpeg: int, now_ns: int) -> float | None:
        """Returns the age of a JPEG; the headset sends the same ones again and again."""
        earlier = [it for it in self._by_jpeg[jpeg] if it <= now_ns]
        return (now_ns - max(earlier)) / 1e6 if earlier else None


def main(duration_s: float) -> None:
    environment = isolated_environment()
    os.environ |= environment
    with tempfile.TemporaryDirectory(prefix="ml2_view") as name, ExitStack() as stack:
        folder, stamps = Path(name), Stamps()
        (folder / "config.yaml").write_text(compressed_config())
        _start(stack, folder, environment)
        measured_s = min(duration_s, _LATENCY_S)
        without_ms = imu_p99_ms(latency(measured_s))
        view = stack.enter_context(
            process([RECEIVER, "view", "--no-browser", "--eyes"], environment, folder / "view.log")
        )
        address, usage = line_with(view, "open ").split()[1], Usage(view.pid)
        diagnostics = DiagnosticsNode()
        stack.callback(diagnostics.close)
        node = stack.enter_context(tool_node("view_bench"))
        stack.callback(RawTaker(node, [stamps.subscription()], Faults().add).stop)
        client = Client(address)
        _run(client, _WARM_UP_S)
        client.images.clear()
        client.color.clear()
        lost, began_s = _lost(diagnostics), time.monotonic()
        beside = latency(measured_s)
        _run(client, duration_s, usage)
        passed_s = time.monotonic() - began_s
        ages_ms = [stamps.latency_ms(*it) for it in client.color]
        results = {
            "cpu_percent": usage.cpu_percent,
            "rss_mb": usage.rss_bytes[-1] / 1e6,
            "memory_mb_per_hour": usage.memory_mb_per_hour,
            "threads_grown": growth(usage.threads),
            "files_grown": growth(usage.files),
            "imu_p99_ms": {"without": without_ms, "with": imu_p99_ms(beside)},
            "latency_p50_ms": statistics.median(it for it in ages_ms if it is not None),
            "images_per_s": len(client.images) / passed_s,
            "receiver_drops": _lost(diagnostics) - lost,
            "duration_s": passed_s,
        }
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")


def _start(stack: ExitStack, folder: Path, environment: dict[str, str]) -> None:
    """Starts receiver and headset."""

    def start(name: str, command: list[str | Path]) -> subprocess.Popen[str]:
        return stack.enter_context(process(command, environment, folder / f"{name}.log"))

    receiver = start("receiver", receive_command(folder / "config.yaml", "127.0.0.1:0"))
    start("headset", headset_command(listening_address(receiver)))


def latency(duration_s: float) -> subprocess.Popen[str]:
    """Starts `ml2-receiver latency`, which takes every topic, for this time."""
    command: list[str | Path] = [RECEIVER, "latency", "--once", "--duration", str(duration_s)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def imu_p99_ms(measuring: subprocess.Popen[str]) -> float:
    """Waits for the table of `latency`, whose last column but one is p99."""
    rows = map(str.split, measuring.communicate()[0].splitlines())
    return next(float(row[-2]) for row in rows if row and row[0] == _IMU)


def _run(client: Client, duration_s: float, usage: Usage | None = None) -> None:
    """Takes what comes, and samples the usage about once per second."""
    end_s = time.monotonic() + duration_s
    due_s = 0.0
    while (now_s := time.monotonic()) < end_s:
        client.take()
        if usage is not None and now_s >= due_s:
            usage.sample()
            due_s = now_s + 1.0


def _lost(diagnostics: DiagnosticsNode) -> int:
    return sum(it["lost"] for it in topic_figures(diagnostics.rows("", _TIMEOUT_S)))


if __name__ == "__main__":
    main(float(sys.argv[1]))

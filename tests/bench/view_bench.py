"""Measures what `ml2-receiver view` costs while a client is shown all that there is.

Usage: view_bench.py DURATION, in seconds. Writes build/bench/view.json:

cpu_percent     the process of `view`, in percent of one processor
rss_mb          its memory at the end
memory_mb_per_hour the slope of its memory without files
threads_grown   how many more threads it has at the end than at the beginning
files_grown     the same of open files
without, with   three turns in alternation, of 30 s at most, without `view` and with it:
                imu_p99_ms, from capture to `ml2-receiver latency`, which runs in both
                receiver_cpu_percent, headset_cpu_percent
imu_p99_ms, receiver_cpu_percent, headset_cpu_percent: their medians
latency_p50_ms  from capture to the client, of images of the RGB camera
images_per_s    images of all cameras that the client got
receiver_drops  messages of all topics that the receiver lost meanwhile
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import partial
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
_TURNS = 3
_TIMEOUT_S = 60.0
_NICENESS = 5


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
    turns: dict[str, list[dict[str, float]]] = {"without": [], "with": []}
    turn_s = min(duration_s, _LATENCY_S)
    with tempfile.TemporaryDirectory(prefix="ml2_view") as name, ExitStack() as stack:
        folder = Path(name)
        (folder / "config.yaml").write_text(compressed_config())
        pids = _start(stack, folder, environment)
        _usual(pids, _WARM_UP_S, time.sleep)
        for _ in range(_TURNS - 1):
            turns["without"].append(_usual(pids, turn_s, time.sleep))
            with _view(folder, environment) as (_, client):
                turns["with"].append(_usual(pids, turn_s, partial(_run, client)))
        turns["without"].append(_usual(pids, turn_s, time.sleep))
        stamps = Stamps()
        diagnostics = DiagnosticsNode()
        stack.callback(diagnostics.close)
        node = stack.enter_context(tool_node("view_bench"))
        stack.callback(RawTaker(node, [stamps.subscription()], Faults().add).stop)
        with _view(folder, environment) as (view, client):
            usage = Usage(view.pid)
            client.images.clear()
            client.color.clear()
            lost, began_s = _lost(diagnostics), time.monotonic()
            turns["with"].append(_usual(pids, turn_s, partial(_run, client, usage=usage)))
            _run(client, began_s + duration_s - time.monotonic(), usage)
            passed_s = time.monotonic() - began_s
        ages_ms = [stamps.latency_ms(*it) for it in client.color]
        results: dict[str, object] = {
            "cpu_percent": usage.cpu_percent,
            "rss_mb": usage.rss_bytes[-1] / 1e6,
            "memory_mb_per_hour": usage.memory_mb_per_hour,
            "threads_grown": growth(usage.threads),
            "files_grown": growth(usage.files),
            "latency_p50_ms": statistics.median(it for it in ages_ms if it is not None),
            "images_per_s": len(client.images) / passed_s,
            "receiver_drops": _lost(diagnostics) - lost,
            "duration_s": passed_s,
        }
    for figure in turns["with"][0]:
        results[figure] = {
            name: statistics.median(it[figure] for it in found) for name, found in turns.items()
        }
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(results | turns, indent=2) + "\n")


def _usual(
    pids: dict[str, int], duration_s: float, meanwhile: Callable[[float], None]
) -> dict[str, float]:
    """Measures receiver and headset while the caller does something for this time."""
    usage = {role: Usage(pid) for role, pid in pids.items()}
    imu = latency(duration_s)
    for each in usage.values():
        each.sample()
    meanwhile(duration_s)
    for each in usage.values():
        each.sample()
    cpu = {f"{role}_cpu_percent": each.cpu_percent for role, each in usage.items()}
    return {"imu_p99_ms": imu_p99_ms(imu), **cpu}


@contextmanager
def _view(
    folder: Path, environment: dict[str, str]
) -> Iterator[tuple[subprocess.Popen[str], Client]]:
    """Starts `view`, and a client that is shown everything."""
    command: list[str | Path] = [RECEIVER, "view", "--no-browser", "--eyes"]
    with process(command, environment, folder / "view.log") as view:
        client = Client(line_with(view, "open ").split()[1])
        _run(client, _WARM_UP_S)
        yield view, client


def _start(stack: ExitStack, folder: Path, environment: dict[str, str]) -> dict[str, int]:
    """Starts receiver and headset, and returns their process ids."""

    def start(name: str, command: list[str | Path]) -> subprocess.Popen[str]:
        return stack.enter_context(process(command, environment, folder / f"{name}.log"))

    receiver = start("receiver", receive_command(folder / "config.yaml", "127.0.0.1:0"))
    headset = start("headset", headset_command(listening_address(receiver)))
    return {"receiver": receiver.pid, "headset": headset.pid}


def latency(duration_s: float) -> subprocess.Popen[str]:
    """Starts `ml2-receiver latency`, which takes every topic, for this time."""
    command: list[str | Path] = [RECEIVER, "latency", "--once", "--duration", str(duration_s)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def imu_p99_ms(measuring: subprocess.Popen[str]) -> float:
    """Waits for the table of `latency`, whose last column but one is p99."""
    rows = map(str.split, measuring.communicate()[0].splitlines())
    return next(float(row[-2]) for row in rows if row and row[0] == _IMU)


def _run(client: Client, duration_s: float, usage: Usage | None = None) -> None:
    """Takes what comes, as a browser would, and samples the usage about once per second."""
    with ThreadPoolExecutor(1, initializer=_give_way) as beside:
        beside.submit(_take, client, duration_s, usage).result()


def _give_way() -> None:
    """Schedules this thread as a browser that `view` starts."""
    os.nice(_NICENESS)
    os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def _take(client: Client, duration_s: float, usage: Usage | None) -> None:
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

"""Measures the Zenoh sink: CPU time, the longest put, and inertial samples on a thin link.

The router is a session of eclipse-zenoh in mode `router`, in a process of its own. CPU is that of
the whole publishing process. `unsubscribed` has no subscriber, `shared` one behind a router on this
machine by shared memory, `tcp` the same without shared memory. `rclpy_cpu_ms_per_mb` has the same
payloads by rclpy's raw publish. Images come 100 times per second, small messages 2000 times. The
longest put is that of 300 images of 1 MB while the subscriber, or the router, stands still. `busy`
has the time of a put while four cameras send raw images through TCP, two of them through the sink
and two by Zenoh's binding alone: what both have is of Zenoh, or of a machine that is busy. The thin
link is a token bucket of 20 Mbit/s, which images fill; it needs root.
"""

import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import zenoh

from ml2_receiver.session.sink import Publish
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Qos
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.names import TopicName
from ros_processes import Subscriber, environment
from shaped_link import Machine, link, why_not
from waiting import await_true
from zenoh_peers import free_endpoint
from zenoh_roles import IMAGE, IMAGE_BYTES, IMU, IMU_BYTES, sink_of

_ROLES = Path(__file__).with_name("zenoh_roles.py")
_PERIOD_S, _SMALL_PERIOD_S = 0.01, 0.0005
_IMAGE_PERIOD_S = 1 / 30
_MOST_S = 120
_MEGABYTES = IMAGE_BYTES / 1e6
_WITHOUT_SHARED_MEMORY = {"transport": {"shared_memory": {"enabled": False}}}
# Network namespaces of one machine share its memory, which would bypass the link.
_THIN = {"transport": {"link": {"tcp": {"so_sndbuf": 65536}}, "shared_memory": {"enabled": False}}}
_THIN_MBIT = 20


def main(results_file: Path, count: int, duration_s: float) -> None:
    results = costs(count) | {"longest_put_ms": {it: longest_ms(it) for it in ("read", "route")}}
    results["busy"] = busy(duration_s)
    reason = why_not()
    results["thin_link"] = thin_link(duration_s) if reason is None else {"not_measured": reason}
    results["load_average"] = os.getloadavg()[0]
    results_file.parent.mkdir(parents=True, exist_ok=True)
    results_file.write_text(json.dumps(results, indent=2) + "\n")


@contextmanager
def role(*arguments: str, host: Machine | None = None) -> Iterator[subprocess.Popen[str]]:
    prefix = () if host is None else host.prefix
    command = (*prefix, sys.executable, str(_ROLES), *arguments)
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, **pipes) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "ready\n"
        try:
            yield child
        finally:
            child.kill()


@contextmanager
def configuration(values: dict[str, Any]) -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "zenoh.json5")
        file.write_text(json.dumps(values))
        yield file


@contextmanager
def publishers(
    values: dict[str, Any], *, is_subscribed: bool
) -> Iterator[tuple[Publish, Publish, Publish, dict[str, subprocess.Popen[str]]]]:
    """Functions that publish an image, an inertial sample, and one by Zenoh's binding alone; and
    the other processes."""
    endpoint = free_endpoint()
    with (
        role("route", endpoint) as router,
        configuration(values) as file,
        zenoh.open(session_configuration(endpoint, file)) as session,
    ):
        sink = sink_of(session)
        image, imu, put = sink.open(IMAGE), sink.open(IMU), bare_put(session)
        if not is_subscribed:
            yield image, imu, put, {"route": router}
            return
        with role("read", endpoint) as reader:
            await_true(lambda: all(sink.demand().values()))
            yield image, imu, put, {"route": router, "read": reader}


def bare_put(
    session: zenoh.Session, name: str = "bare", priority: zenoh.Priority = zenoh.Priority.REAL_TIME
) -> Publish:
    publisher = session.declare_publisher(
        TopicName(f"/m/{name}", IMU.type, Qos(10)).key(0),
        congestion_control=zenoh.CongestionControl.DROP,
        priority=priority,
        reliability=zenoh.Reliability.RELIABLE,
    )
    return lambda payload: publisher.put(payload, attachment=bytes(33))


def cpu_s(publish: Publish, payload_bytes: int, count: int, period_s: float = _PERIOD_S) -> float:
    """CPU time of this process per message, without that of waiting for the next one."""
    _publish(publish, payload_bytes, 20, period_s)
    pauses_s = _publish(lambda _: None, 1, count, period_s)
    return _publish(publish, payload_bytes, count, period_s) - pauses_s


def _publish(publish: Publish, payload_bytes: int, count: int, period_s: float) -> float:
    payload = bytearray(payload_bytes)
    began_s = time.process_time()
    for _ in range(count):
        publish(payload)
        time.sleep(period_s)
    return (time.process_time() - began_s) / count


def costs(count: int) -> dict[str, Any]:
    of_images: dict[str, float] = {}
    small: list[float] = []
    bare: list[float] = []
    for name, values, is_subscribed in (
        ("unsubscribed", {}, False),
        ("shared", {}, True),
        ("tcp", _WITHOUT_SHARED_MEMORY, True),
    ):
        with publishers(values, is_subscribed=is_subscribed) as (image, imu, put, _):
            of_images[name] = cpu_s(image, IMAGE_BYTES, count) * 1e3 / _MEGABYTES
            if is_subscribed:
                for costs_us, publish in ((small, imu), (bare, put)):
                    costs_us.append(cpu_s(publish, IMU_BYTES, 10 * count, _SMALL_PERIOD_S) * 1e6)
    return {
        "cpu_ms_per_mb": of_images,
        "us_per_small": statistics.mean(small),
        "us_per_small_bare": statistics.mean(bare),
        "rclpy_cpu_ms_per_mb": rclpy_costs(count),
    }


def rclpy_costs(count: int) -> dict[str, float]:
    os.environ |= {key: it for key, it in environment().items() if key.startswith("ROS_")}
    import rclpy
    from sensor_msgs.msg import Image

    from ml2_receiver.ros.raw_publish import raw_publish, takes_bytearray

    rclpy.init()
    node = rclpy.create_node("bench")
    publisher = node.create_publisher(Image, "/bench", 5)
    publish = raw_publish(publisher, takes_bytearray(publisher, Image()))

    def cost() -> float:
        return cpu_s(publish, IMAGE_BYTES, count) * 1e3 / _MEGABYTES

    costs = {"unsubscribed": cost()}
    with Subscriber("/bench", "sensor_msgs/msg/Image"):
        await_true(lambda: publisher.get_subscription_count() > 0)
        costs["subscribed"] = cost()
    node.destroy_node()
    rclpy.shutdown()
    return costs


def longest_ms(stalled: str) -> float:
    with publishers(_WITHOUT_SHARED_MEMORY, is_subscribed=True) as (image, _, _, children):
        payload = bytearray(IMAGE_BYTES)
        children[stalled].send_signal(signal.SIGSTOP)
        longest_s = 0.0
        for _ in range(300):
            longest_s = max(longest_s, _elapsed_s(lambda: image(payload)))
            time.sleep(_PERIOD_S)
        children[stalled].send_signal(signal.SIGCONT)
    return longest_s * 1e3


def _elapsed_s(act: Callable[[], None]) -> float:
    began_s = time.perf_counter()
    act()
    return time.perf_counter() - began_s


def busy(duration_s: float) -> dict[str, Any]:
    endpoint, streams, low = free_endpoint(), load_table().streams, zenoh.Priority.DATA_LOW
    with (
        role("route", endpoint),
        configuration(_WITHOUT_SHARED_MEMORY) as file,
        zenoh.open(session_configuration(endpoint, file)) as session,
        role("read", endpoint),
    ):
        sink = sink_of(session)
        ours = [sink.open(streams[it].topics[0]) for it in ("world_left", "world_right")]
        bare = [bare_put(session, it, low) for it in ("one", "other")]
        await_true(lambda: all(sink.demand().values()))
        puts = {"sink": ours, "bare": bare}
        with ThreadPoolExecutor() as pool:
            asked = {
                name: [pool.submit(_elapsed_each_s, it, duration_s) for it in them]
                for name, them in puts.items()
            }
        found = {
            name: sorted(s for it in them for s in it.result()) for name, them in asked.items()
        }
    return {
        name: {
            "put_p50_ms": statistics.median(it) * 1e3,
            "put_p99_ms": it[len(it) * 99 // 100] * 1e3,
        }
        for name, it in found.items()
    } | {"load_average": os.getloadavg()[0]}


def _elapsed_each_s(publish: Publish, duration_s: float) -> list[float]:
    payload, found = bytearray(IMAGE_BYTES), []
    end_s = time.monotonic() + duration_s
    while time.monotonic() < end_s:
        found.append(_elapsed_s(lambda: publish(payload)))
        time.sleep(_IMAGE_PERIOD_S)
    return found


def thin_link(duration_s: float) -> dict[str, float]:
    with link("cubic", _THIN_MBIT) as made, configuration(_THIN) as file:
        endpoint = f"tcp/{made.receiver.address}:7447"
        with (
            role("route", endpoint, host=made.receiver),
            role("delays", endpoint, host=made.receiver) as reader,
        ):
            with role("load", endpoint, str(file), str(duration_s), host=made.headset) as sender:
                assert sender.stdout is not None
                published = json.loads(sender.stdout.readline())
            found = json.loads(reader.communicate(timeout=_MOST_S)[0])
    ms = sorted(it / 1e6 for it in found["delays_ns"])
    return {
        "imu_p50_ms": statistics.median(ms),
        "imu_p99_ms": ms[int(0.99 * len(ms))],
        "imu_lost": found["lost"],
        "imu_received": len(ms),
        "imu_published": published[f"/m/{IMU.name}"],
        "images_received": found["images"],
        "images_published": published[f"/m/{IMAGE.name}"],
    }


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))

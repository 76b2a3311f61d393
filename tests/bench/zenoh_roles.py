"""The processes of zenoh_bench.py.

Usage: zenoh_roles.py route|read|delays ENDPOINT, or load ENDPOINT CONFIG SECONDS, or
headsets ENDPOINT NUMBER MESSAGES_PER_S. `route` is a router. `read` takes everything. `delays`
prints at the end of its input the delays of inertial samples in ns, from publishing to arrival, and
how many it lacks. `load` publishes images and inertial samples through the receiver's sink.
`headsets` are so many sessions with all topics of a headset, each of which publishes so many
inertial samples per second in sum.
"""

import itertools
import json
import struct
import sys
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import zenoh

from ml2_receiver.session.sink import Publish
from ml2_receiver.table.reader import load_table
from ml2_receiver.zenoh.configuration import session_configuration
from ml2_receiver.zenoh.sink import ZenohSink
from zenoh_peers import open_client, open_router

IMAGE_BYTES, IMU_BYTES = 1_000_000, 324
IMAGE = next(it for it in load_table().streams["world_left"].topics if it.role == "image")
IMU = load_table().streams["gyro_left"].topics[0]
EVERYTHING = "0/**"
_IMAGE_PERIOD_S, _IMU_PERIOD_S = 1 / 30, 1 / 500
_ATTACHMENT = struct.Struct("<qq")


def sink_of(session: zenoh.Session) -> ZenohSink:
    return ZenohSink(session, load_table(), "/m", "", 0, lambda: None)


def route(endpoint: str) -> None:
    with open_router(endpoint):
        wait_for_the_end()


def read(endpoint: str) -> None:
    with open_client(endpoint) as session:
        session.declare_subscriber(EVERYTHING, lambda _: None)
        wait_for_the_end()


def delays(endpoint: str) -> None:
    found: list[tuple[int, int]] = []
    images = 0

    def take(sample: zenoh.Sample) -> None:
        nonlocal images
        now_ns = time.time_ns()
        images += IMAGE.name in str(sample.key_expr)
        if IMU.name in str(sample.key_expr) and sample.attachment is not None:
            number, sent_ns = _ATTACHMENT.unpack_from(sample.attachment.to_bytes())
            found.append((number, now_ns - sent_ns))

    with open_client(endpoint) as session:
        session.declare_subscriber(EVERYTHING, take)
        wait_for_the_end()
    lost = found[-1][0] - found[0][0] + 1 - len(found)
    delays_ns = [delay_ns for _, delay_ns in found]
    print(json.dumps({"delays_ns": delays_ns, "lost": lost, "images": images}))


def load(endpoint: str, config: str, duration_s: str) -> None:
    with zenoh.open(session_configuration(endpoint, Path(config))) as session:
        sink = sink_of(session)
        ended = threading.Event()
        threads = [
            threading.Thread(target=_publish, args=[sink.open(topic), count, period_s, ended])
            for topic, count, period_s in (
                (IMAGE, IMAGE_BYTES, _IMAGE_PERIOD_S),
                (IMU, IMU_BYTES, _IMU_PERIOD_S),
            )
        ]
        print("ready", flush=True)
        for thread in threads:
            thread.start()
        time.sleep(float(duration_s))
        ended.set()
        for thread in threads:
            thread.join()
        time.sleep(1)  # what is queued arrives
        print(json.dumps(dict(sink.published())))
        sink.close()


def headsets(endpoint: str, number: str, messages_per_s: str) -> None:
    rate_hz, ended = float(messages_per_s), threading.Event()
    topics = [topic for stream in load_table().streams.values() for topic in stream.topics]
    with ExitStack() as stack:
        sinks, publishers = [], []
        for index in range(int(number)):
            config = session_configuration(endpoint, None)
            # As of other machines; a router has shared memory for 351 sessions of its own
            config.insert_json5("transport/shared_memory/enabled", "false")
            session = stack.enter_context(zenoh.open(config))
            sink = ZenohSink(session, load_table(), f"/h{index}", f"h{index}", 0, lambda: None)
            publishers.append({topic: sink.open(topic) for topic in topics}[IMU])
            sinks.append(sink)  # whose topics end when Python collects it
        print("ready", flush=True)
        if rate_hz:
            period_s = 1 / (rate_hz * len(publishers))
            everywhere = itertools.cycle(publishers)

            def publish(payload: bytearray) -> None:
                next(everywhere)(payload)

            threading.Thread(target=_publish, args=[publish, IMU_BYTES, period_s, ended]).start()
        sys.stdin.read()
        ended.set()


def _publish(publish: Publish, count: int, period_s: float, ended: threading.Event) -> None:
    payload = bytearray(count)
    due_s = time.monotonic()
    while not ended.wait(max(0.0, due_s - time.monotonic())):
        publish(payload)
        due_s += period_s


def wait_for_the_end() -> None:
    print("ready", flush=True)
    sys.stdin.read()


ROLES: dict[str, Callable[..., None]] = {
    "route": route,
    "read": read,
    "delays": delays,
    "load": load,
    "headsets": headsets,
}

if __name__ == "__main__":
    ROLES[sys.argv[1]](*sys.argv[2:])

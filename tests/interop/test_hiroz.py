"""hiroz, an implementation of ROS 2 on Zenoh in Rust, lists our topics and reads them.

It keeps to the conventions of rmw_zenoh and has its own hashes of types. `make interop` builds the
program hiroz_reader.
"""

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import bag_scene
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.topics.plain_messages import encode_string
from ml2_receiver.zenoh.sink import ZenohSink
from waiting import LIMIT_S, await_true
from zenoh_scene import DOMAIN, IMAGE, IMU, METADATA, PREFIX, imu, open_topics, routed_sink

READER = Path(__file__).resolve().parents[2] / "build" / "interop" / "debug" / "hiroz_reader"


@pytest.fixture(scope="module")
def site() -> Iterator[tuple[str, ZenohSink]]:
    with routed_sink() as site:
        yield site


def reader(endpoint: str, *command: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [READER, endpoint, str(DOMAIN), *command], stdout=subprocess.PIPE, text=True
    )


def read(site: tuple[str, ZenohSink], topic: Topic, payload: bytes) -> Any:
    """Returns what hiroz reads from a payload that we publish."""
    endpoint, sink = site
    publish = sink.open(topic)
    with reader(endpoint, "read", topic.type, topic.full_name(PREFIX)) as child:
        try:
            await_true(lambda: sink.demand()[topic.stream])
            publish(bytearray(payload))
            return json.loads(child.communicate(timeout=LIMIT_S)[0])
        finally:
            child.kill()


def test_it_reads_an_imu_sample(site: tuple[str, ZenohSink]) -> None:
    found = read(site, IMU, imu())
    assert found["header"] == {"stamp": {"sec": 17, "nanosec": 5}, "frame_id": "gyro_left"}
    assert found["angular_velocity"] == {"x": 0.25, "y": -1.5, "z": 3.0}
    assert found["linear_acceleration"]["y"] == 9.75


def test_it_reads_an_image(site: tuple[str, ZenohSink]) -> None:
    found = read(site, IMAGE, bag_scene.image(3))
    pixels = bag_scene.pixels(3)
    assert ((found["height"], found["width"]), found["encoding"]) == (pixels.shape, "mono8")
    assert bytes(found["data"]) == pixels.tobytes()


def test_it_reads_a_string(site: tuple[str, ZenohSink]) -> None:
    text = '{"exposure_ms": 3}'
    assert read(site, METADATA, encode_string(text)) == {"data": text}


def mangled(type: str) -> str:
    """A type as keys of Zenoh have it, which hiroz does not translate back."""
    return type.replace("/msg/", "::msg::dds_::") + "_"


def test_it_lists_our_topics_with_their_types(site: tuple[str, ZenohSink]) -> None:
    endpoint, sink = site
    expected = {name: mangled(type) for name, type in open_topics(sink).items()}
    with reader(endpoint, "list", *expected) as child:
        try:
            lines = child.communicate(timeout=LIMIT_S)[0].splitlines()
        finally:
            child.kill()
    found = dict(line.split() for line in lines)
    # Its own node may be there already
    assert {name: found[name] for name in expected} == expected

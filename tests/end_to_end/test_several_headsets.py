"""Four headsets stream in one ROS domain, each with its own topics, frames and counters."""

from __future__ import annotations

import contextlib

import pytest

from configurations import only
from counters import await_snapshot, have_arrived
from processes import (
    PREFIX,
    Received,
    headset_command,
    isolated_environment,
    listening_address,
    process,
    receive_command,
    result,
    subscribing,
)
from simulation import STILL

NAMES = ["robot1", "robot2", "robot3", "robot4"]
LEAST = 21
TOPICS = (f"{PREFIX}/color/image_raw/compressed", f"{PREFIX}/head_pose")
CONFIG = only(
    """
    picture_center: {enabled: true, resolution_width: 640, resolution_height: 480},
    head_pose: {enabled: true},
    """
)


@pytest.fixture(scope="module")
def received(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Received]:
    folder = tmp_path_factory.mktemp("several")
    config = folder / "config.yaml"
    config.write_text(CONFIG)
    environment = isolated_environment()
    found = {}
    with contextlib.ExitStack() as stack:
        subscribers, headsets = {}, []
        for name in NAMES:
            logs = folder / name
            logs.mkdir()
            # A subscriber that stands still for a moment loses nothing.
            deep = [f"-p qos_overrides./{name}{it}.publisher.depth:=1000" for it in TOPICS]
            ros = ["--ros-args", *(word for it in deep for word in it.split())]
            command = receive_command(config, "127.0.0.1:0", "--start-paused", "--name", name, *ros)
            receiver = stack.enter_context(process(command, environment, logs / "receiver.log"))
            subscribers[name] = stack.enter_context(subscribing(environment, logs, name))
            headset = headset_command(listening_address(receiver), *STILL)
            log = logs / "headset.log"
            headsets.append(stack.enter_context(process(headset, environment, log)))
        for subscriber in subscribers.values():
            await_snapshot(subscriber, have_arrived({}, of_others=LEAST))
        for running in headsets:
            running.terminate()
        for name, subscriber in subscribers.items():
            found[name] = result(subscriber, folder / name)
    return found


@pytest.mark.parametrize("name", NAMES)
def test_each_headset_has_its_own_topics_and_loses_nothing(
    received: dict[str, Received], name: str
) -> None:
    own = received[name]
    for topic in TOPICS:
        full = f"/{name}{topic}"
        assert len(own.topics[full][1]) >= LEAST
        counters = own.counters(full)
        assert int(counters["received"]) == len(own.topics[full][1])
        assert int(counters["produced"]) == int(counters["received"]) + int(counters["gaps"])


@pytest.mark.parametrize("name", NAMES)
def test_each_headset_has_its_own_frames(received: dict[str, Received], name: str) -> None:
    own = received[name]
    image = own.messages(f"/{name}{PREFIX}/color/image_raw/compressed")[-1]
    assert image.header.frame_id == f"{name}/color_optical_frame"
    frames = {
        frame
        for message in own.messages("/tf")
        for it in message.transforms
        for frame in (it.header.frame_id, it.child_frame_id)
    }
    assert f"{name}/color_frame" in frames
    assert all(frame.startswith(tuple(NAMES)) for frame in frames)

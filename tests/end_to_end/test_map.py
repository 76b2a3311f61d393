"""The map of the headset: its transform and its state, as subscribers get them."""

from __future__ import annotations

import contextlib
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.qos import QoSProfile
from rclpy.serialization import deserialize_message
from tf2_msgs.msg import TFMessage

from capture_stamps import nanos, stamp_ns
from configurations import only
from counters import await_more, await_snapshot, have_arrived
from euroc import Matrix
from ml2_receiver.ros.context import tool_node
from ml2_receiver.ros.raw_taker import RawSubscription, RawTaker
from processes import (
    Received,
    headset_command,
    isolated_environment,
    listening_address,
    process,
    receive,
    receive_command,
    result,
    subscribing,
)
from simulation import EXACT, SIMULATE, simulate
from transforms import matrix
from waiting import await_true

STARTS = 10
GAZE_HZ = 60
CONFIG = only(
    """
    markers: {enabled: true, type: aruco, dictionary: 5X5_100, size_m: 0.48},
    map: {enabled: true, localize: Second room},
    gaze: {enabled: true}
    """
)
OF_OPENXR = CONFIG.replace("gaze: {", 'gaze: {"backend": "openxr", ')
UUID = "28282828-2828-2828-2828-282828282828"
WORLD = "magicleap_world"


@pytest.fixture(scope="module")
def starts(tmp_path_factory: pytest.TempPathFactory) -> Received:
    """Ten headsets at one receiver, one after the other, whose worlds begin where their heads are.

    All but the last are killed, since the subscriber stops when a headset says goodbye.
    """
    folder = tmp_path_factory.mktemp("starts")
    with contextlib.ExitStack() as stack:
        subscriber, address, environment = listening(folder, CONFIG, stack)
        stamps = stack.enter_context(stamps_of_worlds(environment))
        keys = ("tags=5X5_100", "loop_seconds=600", "fault.head.new_session=1")
        options = [*EXACT, *(word for key in keys for word in ("--simulate", key))]
        for number in range(STARTS):
            begun_ns = time.time_ns()
            command = headset_command(address, *options)
            with process(command, environment, folder / f"headset_{number}.log") as headset:
                await_more(subscriber, "markers", 20)
                await_newer(stamps, begun_ns)
                if number < STARTS - 1:
                    headset.kill()
        return result(subscriber, folder)


@pytest.fixture(scope="module")
def changes(tmp_path_factory: pytest.TempPathFactory) -> Received:
    """The origin moves without an event, later the confidence falls.

    The gaze, which another interface of the headset delivers, appears directly after each.
    """
    folder = tmp_path_factory.mktemp("changes")
    with contextlib.ExitStack() as stack:
        subscriber, address, environment = listening(folder, CONFIG, stack)
        closed = ("--simulate", "fault.gaze.closed=1")
        command = headset_command(address, *EXACT, *closed, *SIMULATE)
        log = folder / "headset.log"
        headset = stack.enter_context(process(command, environment, log, stdin=subprocess.PIPE))
        await_snapshot(subscriber, have_arrived({"map/state": 4}))
        simulate(headset, "openxr.map.moved_mm=500", "fault.gaze.closed=0")
        await_more(subscriber, "gaze", 20)
        simulate(headset, "fault.gaze.closed=1")
        await_more(subscriber, "map/state", 2)
        simulate(headset, "openxr.map.errors=16", "openxr.map.confidence=0", "fault.gaze.closed=0")
        await_more(subscriber, "gaze", 60)
        headset.terminate()
        return result(subscriber, folder)


def listening(
    folder: Path, config: str, stack: contextlib.ExitStack
) -> tuple[subprocess.Popen[str], str, dict[str, str]]:
    """Starts a receiver and a subscriber; returns that, the address and their environment."""
    (folder / "config.yaml").write_text(config)
    environment = isolated_environment()
    command = receive_command(folder / "config.yaml", "127.0.0.1:0", "--start-paused")
    receiver = stack.enter_context(process(command, environment, folder / "receiver.log"))
    subscriber = stack.enter_context(subscribing(environment, folder))
    return subscriber, listening_address(receiver), environment


@contextlib.contextmanager
def stamps_of_worlds(environment: dict[str, str]) -> Iterator[list[int]]:
    """Yields a list that gets the stamp in ns of each transform from the map to the world."""
    stamps = [0]

    def take(payload: bytes) -> None:
        for it in deserialize_message(payload, TFMessage).transforms:
            if it.child_frame_id == WORLD:
                stamps.append(nanos(it.header.stamp))

    with pytest.MonkeyPatch.context() as patch, contextlib.ExitStack() as stack:
        for name, value in environment.items():
            patch.setenv(name, value)
        node = stack.enter_context(tool_node("listener"))
        heard = RawSubscription("tf2_msgs/msg/TFMessage", "/tf", QoSProfile(depth=100), take)
        stack.callback(RawTaker(node, [heard], lambda _, error: None).stop)
        yield stamps


def await_newer(stamps: list[int], than_ns: int) -> None:
    await_true(lambda: stamps[-1] > than_ns)


def transforms(received: Received) -> dict[str, list[tuple[int, Matrix]]]:
    """Returns the stamps in ns and poses of each frame in its parent, by stamp."""
    found: dict[str, list[tuple[int, Matrix]]] = {}
    for message in received.messages("/tf"):
        for it in message.transforms:
            expected = "magicleap_map" if it.child_frame_id == WORLD else WORLD
            assert it.header.frame_id == expected
            of_frame = found.setdefault(it.child_frame_id, [])
            of_frame.append((nanos(it.header.stamp), matrix(it.transform)))
    return {frame: sorted(poses, key=lambda it: it[0]) for frame, poses in found.items()}


def appearances_ns(received: Received) -> tuple[int, int]:
    """Returns the stamps of the first gaze and of the first one after its longest pause."""
    stamps = sorted(stamp_ns(it) for it in received.messages("gaze"))
    return stamps[0], stamps[int(np.argmax(np.diff(stamps))) + 1]


def is_at_once(received: Received, since_ns: int, at_ns: int) -> bool:
    """Returns whether less than 200 ms passed, not counting while the headset stood still."""
    gazes = sum(since_ns < stamp_ns(it) < at_ns for it in received.messages("gaze"))
    return gazes < 0.2 * GAZE_HZ


def states(received: Received) -> list[tuple[int, Any]]:
    """Returns the stamp in ns and the status of each state."""
    messages = received.messages("map/state")
    assert {it.header.frame_id for it in messages} == {"magicleap_map"}
    return [(stamp_ns(it), status) for it in messages for status in it.status]


def values(status: Any) -> dict[str, str]:
    return {it.key: it.value for it in status.values}


def test_a_tag_on_the_wall_stays_where_it_is_in_the_map(starts: Received) -> None:
    found = transforms(starts)
    worlds = found.pop(WORLD)
    stamps = np.array([at for at, _ in worlds])
    tags: dict[str, list[Matrix]] = {}
    for frame, poses in found.items():
        for at, pose in poses if frame.startswith("marker_") else []:
            nearest = int(np.argmin(np.abs(stamps - at)))
            if abs(stamps[nearest] - at) < 100_000_000:
                tags.setdefault(frame, []).append(worlds[nearest][1] @ pose)
    spreads = {
        frame: np.linalg.norm(np.ptp([pose[:3, 3] for pose in poses], axis=0))
        for frame, poses in tags.items()
    }
    assert spreads
    assert max(spreads.values()) < 1e-3, spreads
    origins: list[Matrix] = []
    for _, world in worlds:
        if all(np.linalg.norm(world[:3, 3] - it[:3, 3]) > 1e-3 for it in origins):
            origins.append(world)
    assert len(origins) == STARTS, "each start has a world of its own"
    # A tag of one start alone would show nothing.
    assert max(map(len, tags.values())) > 20 * STARTS / 2


def test_the_state_says_in_which_map_the_headset_is(starts: Received) -> None:
    assert starts.snapshot["streams"]["map"]["result"] == "applied"
    _, last = states(starts)[-1]
    assert (last.level, last.message) == (b"\0", "localized in Second room")
    assert values(last) == {
        "localization": "localized",
        "confidence": "excellent",
        "errors": "",
        "name": "Second room",
        "uuid": UUID,
        "map_type": "on_device",
    }


def test_the_transform_follows_an_origin_that_moves_without_an_event(changes: Received) -> None:
    moved_ns, fallen_ns = appearances_ns(changes)
    worlds = transforms(changes)[WORLD]
    begin = worlds[0][1][:3, 3]
    old = [at for at, it in worlds if np.linalg.norm(it[:3, 3] - begin) < 1e-3]
    new = [at for at, it in worlds if abs(np.linalg.norm(it[:3, 3] - begin) - 0.5) < 1e-3]
    assert len(old) + len(new) == len(worlds)
    assert max(old) < min(new)
    assert max(old) < moved_ns + 100_000_000
    assert min(new) < fallen_ns, "not in another part of the test"


def test_without_confidence_the_transforms_end_and_the_state_says_why(changes: Received) -> None:
    _, fallen_ns = appearances_ns(changes)
    last_ns = transforms(changes)[WORLD][-1][0]
    assert is_at_once(changes, fallen_ns, last_ns)
    told = [(at, it) for at, it in states(changes) if at > last_ns]
    first_ns, status = told[0]
    assert is_at_once(changes, fallen_ns, first_ns)
    assert (status.level, status.message) == (b"\1", "no transform: confidence is poor, low_light")
    assert all(it.level == b"\1" for _, it in told)
    assert not is_at_once(changes, fallen_ns, max(map(stamp_ns, changes.messages("gaze"))))


def test_diagnostics_say_how_well_the_headset_perceives(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text(OF_OPENXR)
    keys = ("openxr.headset.fit=3", "openxr.map.confidence=0", "fault.head.errors=4")
    options = [*EXACT, *(word for key in keys for word in ("--simulate", key))]
    is_enough = have_arrived({"map/state": 4, "gaze": 60, "/tf": 60})
    received = receive(tmp_path / "config.yaml", options, tmp_path, is_enough=is_enough)
    assert WORLD not in transforms(received)
    rows = {
        it.name.partition(": ")[2]: it
        for payload in received.diagnostics
        for it in deserialize_message(payload, DiagnosticArray).status
        if "headset " in it.name and it.level == b"\1"
    }
    assert {name: it.message for name, it in rows.items()} == {
        "headset gaze": "headset fit is bad, eye calibration is fine",
        "headset map": "no transform: confidence is poor",
        "headset tracking": "the head is tracked: low_light",
    }
    assert values(rows["headset gaze"]) == {"headset_fit": "bad", "eye_calibration": "fine"}
    tracking = {"status": "valid", "confidence": "1.00", "errors": "low_light"}
    assert values(rows["headset tracking"]) == tracking
    assert values(rows["headset map"])["confidence"] == "poor"
    log = (tmp_path / "receiver.log").read_text()
    assert log.count("gaze: headset fit is bad, eye calibration is fine") == 1

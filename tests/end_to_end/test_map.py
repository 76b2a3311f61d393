"""The map of the headset: its transform and its state, as subscribers get them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from configurations import only
from counters import have_arrived
from euroc import Matrix
from processes import Received, receive
from transforms import matrix

CONFIG = only(
    """
    markers: {enabled: true, type: aruco, dictionary: 5X5_100, size_m: 0.48},
    map: {enabled: true, localize: Second room}
    """
)
UUID = "28282828-2828-2828-2828-282828282828"
WORLD = ("magicleap_map", "magicleap_world")


def received(folder: pytest.TempPathFactory, keys: tuple[str, ...]) -> Received:
    run = folder.mktemp("map")
    (run / "config.yaml").write_text(CONFIG)
    options = [word for key in ("noise=0", "tags=5X5_100", *keys) for word in ("--simulate", key)]
    least = {"map/state": 3, "markers": 30, "/tf": 60}
    return receive(run / "config.yaml", options, run, is_enough=have_arrived(least))


@pytest.fixture(scope="module")
def starts(tmp_path_factory: pytest.TempPathFactory) -> list[Received]:
    """The second one moves the origin of the world to where the head is."""
    keys: list[tuple[str, ...]] = [(), ("fault.head.new_session=1",)]
    return [received(tmp_path_factory, it) for it in keys]


def transforms(start: Received) -> dict[tuple[str, str], list[Matrix]]:
    found: dict[tuple[str, str], list[Matrix]] = {}
    for message in start.messages("/tf"):
        for it in message.transforms:
            edge = (it.header.frame_id, it.child_frame_id)
            found.setdefault(edge, []).append(matrix(it.transform))
    return found


def state(start: Received) -> Any:
    """Returns the last state."""
    message = start.messages("map/state")[-1]
    assert message.header.frame_id == "magicleap_map"
    (status,) = message.status
    return status


def test_a_tag_on_the_wall_stays_where_it_is_in_the_map(starts: list[Received]) -> None:
    tags: dict[str, list[Matrix]] = {}
    for start in starts:
        edges = transforms(start)
        for (parent, child), poses in edges.items():
            if child.startswith("marker_"):
                assert parent == "magicleap_world"
                tags.setdefault(child, []).append(edges[WORLD][-1] @ poses[-1])
    spreads = [
        np.linalg.norm(np.ptp([pose[:3, 3] for pose in poses], axis=0))
        for poses in tags.values()
        if len(poses) > 1
    ]
    assert spreads
    assert max(spreads) < 1e-3
    worlds = [transforms(start)[WORLD][-1] for start in starts]
    assert np.linalg.norm(worlds[0][:3, 3] - worlds[1][:3, 3]) > 0.1, "the same world twice"


def test_the_state_says_in_which_map_the_headset_is(starts: list[Received]) -> None:
    for start in starts:
        assert start.snapshot["streams"]["map"]["result"] == "applied"
        last = state(start)
        assert (last.level, last.message) == (b"\0", "localized in Second room")
        values = {it.key: it.value for it in last.values}
        assert values == {
            "localization": "localized",
            "confidence": "excellent",
            "errors": "",
            "name": "Second room",
            "uuid": UUID,
            "map_type": "on_device",
        }


def test_without_confidence_there_is_no_transform(tmp_path_factory: pytest.TempPathFactory) -> None:
    keys = ("openxr.map.confidence=0", "openxr.map.errors=16")
    start = received(tmp_path_factory, keys)
    assert WORLD not in transforms(start)
    last = state(start)
    assert (last.level, last.message) == (b"\1", "no transform: confidence is poor, low_light")

"""Distributes the tests over workers, and keeps the recordings that several modules look at."""

from __future__ import annotations

import re
import subprocess
import uuid
from collections.abc import Iterator
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling  # type: ignore[import-untyped]

from counters import Snapshot
from full_load import FullLoad, full_load
from own_environment import MAY_MOUNT_AND_MAKE_NETWORKS
from processes import Received, full_name
from simulation import CAMERAS, EYES, SMALL, STILL, image_topic

# Tests of one group run on one worker, one after another, so that a recording is made once. Two
# groups have all loads that need a processor each, so that no more run at a time.
_GROUPS = (
    r"test_(harsh|several_headsets|doctor_link|export)\.py",
    r"test_(rig|controller|simulated|simulated_geometry|truth|products|recorded_tools|silence)\.py",
    r"test_(outage|reconfiguration)\.py",
    r"test_projection\.py.*\[straight",
    r"test_projection\.py.*\[tangential",
    r"test_projection\.py.*\[openxr",
    r"test_replay\.py.*\[2",
    r"test_replay\.py.*\[max",
    r"test_short_walk\.py",
)
# Each test of these modules has its own processes. The tests of all others are a group by module.
_INDEPENDENT = r"test_(recovery|security|transform_tree|receiver_bench)\.py"


def _group(nodeid: str) -> str:
    """Returns the same text for all tests of a group."""
    if re.search(_INDEPENDENT, nodeid):
        return nodeid
    module = nodeid.split("::", 1)[0]
    return next((group for group in _GROUPS if re.search(group, nodeid)), module)


class _GroupScheduling(LoadScopeScheduling):  # type: ignore[misc]
    """Gives each group to one worker, in the order of collection."""

    def __init__(self, config: pytest.Config, log: Any) -> None:
        config.option.loadscopereorder = False
        super().__init__(config, log)

    def _split_scope(self, nodeid: str) -> str:
        return _group(nodeid)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> _GroupScheduling:
    return _GroupScheduling(config, log)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Puts the groups that take longest first, in their order."""
    order = {group: number for number, group in enumerate(_GROUPS)}
    items.sort(key=lambda item: order.get(_group(item.nodeid), len(order)))


@pytest.fixture(scope="session")
def flat(tmp_path_factory: pytest.TempPathFactory) -> FullLoad:
    """All sensors. Depth with all planes would be half of all bytes at 30 Hz."""
    return full_load(
        tmp_path_factory.mktemp("flat"),
        depth_center={"update_rate": 5, "confidence": True, "flags": True},
        markers={"enabled": True, "type": "aruco", "dictionary": "4X4_50"},
        picture_center={"update_rate": 15, "camera_id": 0},
        map={"enabled": True},
    )


@pytest.fixture(scope="session")
def rig(tmp_path_factory: pytest.TempPathFactory) -> FullLoad:
    """A load for tests that look at no pixels and no eyes, with images of stable cameras."""
    folder = tmp_path_factory.mktemp("rig")
    at_stable: dict[str, int] = {}

    def have_stable_images(snapshot: Snapshot) -> bool:
        said = (folder / "receiver.log").read_text()
        counts = {it: snapshot["topics"][full_name(image_topic(it))]["count"] for it in CAMERAS}
        for camera, count in counts.items():
            if f"the mounting of {camera} is stable" in said:
                at_stable.setdefault(camera, count)
        return all(it in at_stable and counts[it] >= at_stable[it] + 30 for it in CAMERAS)

    return full_load(
        folder,
        *STILL,
        until=have_stable_images,
        tf={"layout": "rig"},
        picture_center=SMALL,
        controller={"backend": "openxr"},
        **{eye: {"enabled": False} for eye in EYES},
    )


@pytest.fixture(scope="session")
def received(flat: FullLoad) -> Received:
    return flat.received


@pytest.fixture
def network() -> Iterator[str]:
    """The name of a network that has only the test's processes, whose ports are free."""
    if not MAY_MOUNT_AND_MAKE_NETWORKS:
        pytest.skip("only root can make a network")
    name = f"ml2test{uuid.uuid4().hex[:6]}"
    for words in (f"netns add {name}", f"-n {name} link set lo up multicast on"):
        subprocess.run(["ip", *words.split()], check=True)
    yield name
    subprocess.run(["ip", "netns", "delete", name], check=True)

"""Which images a snapshot of the page takes."""

from itertools import count
from types import SimpleNamespace
from typing import Any

import pytest

import bag_scene
from ml2_tools.viewing import snapshot

IMAGE = "sensor_msgs/msg/Image"


class Images:
    """A new image each time, as where images come faster than the poses of their captures."""

    def __init__(self) -> None:
        self._numbers = count(1)

    @property
    def newest(self) -> tuple[int, str, bytes]:
        number = next(self._numbers)
        return number, IMAGE, bag_scene.image(number)


class LatePoses:
    """Knows the pose of a capture only when it is asked for it again."""

    def __init__(self) -> None:
        self._asked = set[int]()

    def pose_at(self, _: str, stamp_ns: int) -> Any:
        is_known = stamp_ns in self._asked
        self._asked.add(stamp_ns)
        return "pose" if is_known else None

    def lens(self, _: str) -> str:
        return "lens"


def test_an_image_is_kept_until_its_pose_has_come(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(snapshot, "_POLL_S", 0.001)
    view: Any = SimpleNamespace(images={"depth": Images()}, scene=LatePoses())
    assert snapshot._newest(view, ["depth"])["depth"][0] == 1

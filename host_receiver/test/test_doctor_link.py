"""Doctor beside a running receiver, whose configuration it asks for."""

import json

import pytest

from configurations import only
from mock_device import MockDevice
from ros_processes import Child

pytest.importorskip("rclpy", reason="rclpy is not installed")

CONFIG = only("world_left: {enabled: true, format: jpeg, quality: 60}")
WORLD_MBIT_PER_S = 1016 * 1016e-6 * 1.1 * 30 * 0.65


def test_the_link_is_judged_by_what_the_receiver_asks_for(device: MockDevice) -> None:
    with Child("-m", "ml2_receiver", "doctor", "--json") as child:
        device.expect_link_test()
        device.fill(1000)
        device.fill(0)
        printed = ""
        while not printed.endswith("]"):
            printed += child.line()
    (link,) = [it for it in json.loads(printed) if it["check"] == "link to headset"]
    assert link["numbers"]["needed_mbit_per_s"] == pytest.approx(WORLD_MBIT_PER_S, abs=0.01)

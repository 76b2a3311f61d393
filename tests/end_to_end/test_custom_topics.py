"""A custom topic of the headset's app reaches an independent rclpy subscriber."""

from __future__ import annotations

import itertools
from pathlib import Path

from counters import assert_counters_agree
from processes import PREFIX, Received, receive

CONFIG = """
/ml2_receiver:
  ros__parameters:
    battery: {{enabled: true}}
    custom: {{enabled: {enabled}}}
"""
TOPIC = f"{PREFIX}/custom/app_uptime"


def run(enabled: str, folder: Path) -> Received:
    config = folder / "config.yaml"
    config.write_text(CONFIG.format(enabled=enabled))
    return receive(config, ["--source", "test-signal", "--duration", "2"], folder)


def test_messages_of_a_custom_topic_arrive_like_those_of_a_sensor(tmp_path: Path) -> None:
    received = run("true", tmp_path)
    assert received.topics[TOPIC][0] == "std_msgs/msg/Float64"
    uptimes_s = [message.data for message in received.messages("custom/app_uptime")]
    assert len(uptimes_s) > 10
    steps_s = [b - a for a, b in itertools.pairwise(uptimes_s)]
    assert min(steps_s) >= 0.1
    assert received.qos[TOPIC] == {("RELIABLE", "VOLATILE")}
    counters = received.counters(TOPIC)
    assert counters["received"] == str(len(uptimes_s))
    assert_counters_agree(received)
    assert received.snapshot["streams"]["custom"]["result"] == "applied"


def test_there_are_no_custom_topics_unless_the_user_enables_them(tmp_path: Path) -> None:
    received = run("false", tmp_path)
    assert TOPIC not in received.graph
    assert "custom" not in received.snapshot["streams"]

"""An app may use the names that rules have, and no others."""

import random
import re

import pytest

from ml2_receiver.configuration.app_rules import AppRules, NameRules, matches
from ml2_receiver.table.reader import load_table

PAIRS = 100_000


def by_trying_all(rule: list[str], name: list[str]) -> bool:
    """Returns True if a name matches a rule, by the words of the definition."""
    if not rule:
        return not name
    if rule[0] == "**":
        return any(by_trying_all(rule[1:], name[length:]) for length in range(len(name) + 1))
    return bool(name) and rule[0] in ("*", name[0]) and by_trying_all(rule[1:], name[1:])


def test_rules_mean_what_trying_all_ways_finds() -> None:
    chance = random.Random(64)
    found = {True: 0, False: 0}
    for _ in range(PAIRS):
        rule = chance.choices(["*", "**", "a", "b"], [2, 3, 4, 3], k=chance.randrange(1, 8))
        name = chance.choices("ab", k=chance.randrange(1, 10))
        expected = by_trying_all(rule, name)
        assert matches("/" + "/".join(rule), "/" + "/".join(name)) == expected, (rule, name)
        found[expected] += 1
    assert min(found.values()) > PAIRS / 20, found


def test_a_rule_of_many_stars_takes_no_longer_than_its_length_times_the_names() -> None:
    assert not matches("/**/a" * 40, "/a" * 100 + "/b")


def test_nothing_is_allowed_without_rules() -> None:
    rules = AppRules()
    uses = (rules.subscribe, rules.publish, rules.call, rules.offer)
    assert not any(it.allow("/scan") for it in uses)


def test_a_segment_is_matched_as_a_whole() -> None:
    rules = NameRules(("/robot/*/scan", "/map", "/arm/**"))
    for name in ("/robot/left/scan", "/map", "/arm", "/arm/joint_states", "/arm/a/b/c"):
        assert rules.allow(name), name
    for name in ("/robot/scan", "/robot/a/b/scan", "/maps", "/map/", "/army", "/Map", "map", ""):
        assert not rules.allow(name), name
    assert not NameRules(("/**",)).allow("map")


PRIVATE = (
    "/rosout",
    "/robot/_hidden/topic",
    "/_ros2cli_1234/status",
    "/fibonacci/_action/send_goal",
    "/robot/set_parameters",
    "/set_parameters_atomically",
    "/magic_leap2/eye_nasal_left/image_raw",
    "/robot1/magic_leap2/eye_temple_right/image_raw/compressed",
)


@pytest.mark.parametrize("name", PRIVATE)
def test_a_private_name_is_allowed_by_itself_only(name: str) -> None:
    head, _, tail = name.rpartition("/")
    for rule in ("/**", "/*" * name.count("/"), f"{head}/*", f"/**/{tail}", f"{name}/**"):
        assert not NameRules((rule,)).allow(name), rule
    assert NameRules(("/**", name)).allow(name)


def test_every_topic_of_an_eye_camera_is_private() -> None:
    eyes = [it for it in load_table().streams.values() if it.id.startswith("eye_")]
    topics = [topic.name for stream in eyes for topic in stream.topics]
    assert any(re.fullmatch(r"eye_\w+/image_raw/compressed", it) for it in topics)
    assert not any(NameRules(("/**",)).allow(f"/magic_leap2/{it}") for it in topics)


def test_parameter_services_of_a_node_are_all_private() -> None:
    from rclpy.parameter_service import ParameterService

    class Node:
        def __init__(self) -> None:
            self.services: list[str] = []

        def create_service(self, _type: object, name: str, *_: object, **__: object) -> None:
            self.services.append(name)

        def get_name(self) -> str:
            return "robot"

    node = Node()
    ParameterService(node)
    assert len(node.services) == 6
    assert not any(NameRules(("/**",)).allow(f"/{it}") for it in node.services)


@pytest.mark.parametrize(
    "rule",
    ["", "/", "scan", "~/scan", "/a//b", "/a/", "/a*", "/***", "/1a", "/a-b", "/" + "a" * 255],
)
def test_a_text_that_is_no_rule_is_refused(rule: str) -> None:
    with pytest.raises(ValueError, match="expected an absolute name") as refused:
        NameRules(("/scan", rule))
    assert repr(rule) in str(refused.value)


def test_subscriptions_alone_are_left_where_anybody_could_be_the_app() -> None:
    all_names = NameRules(("/**",))
    left = AppRules(all_names, all_names, all_names, all_names).of_subscriptions()
    assert left == AppRules(subscribe=all_names)

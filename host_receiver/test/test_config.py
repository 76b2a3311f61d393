import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from configurations import only, only_config
from ml2_receiver.configuration.app_rules import AppRules, NameRules
from ml2_receiver.configuration.config import Config, load_config, parse_config
from ml2_receiver.configuration.settings import Settings
from ml2_receiver.errors import ConfigError, Problem
from ml2_receiver.wire.messages import Link

ROOT = Path(__file__).resolve().parents[2]
MIXED = "{enabled: true, stream: 1, resolution_width: 1440, resolution_height: 1080}"
THESIS = Path(__file__).parent / "data/thesis_config.yaml"

# Legal picture_center values, from the specification: stream, rates, resolutions.
COLOR_MODES = [
    (0, {15, 30, 60}, "640x480 1280x720 1280x960 1440x1080 1920x1080 2048x1536"),
    (0, {15, 30}, "2880x2160 3840x2160 4096x3072"),
    (1, {30, 60}, "648x720 972x1080 960x720 1440x1080"),
    (1, {30}, "1944x2160 2880x2160"),
]
COLOR = {
    (stream, tuple(map(int, size.split("x"))), rate)
    for stream, rates, sizes in COLOR_MODES
    for rate in rates
    for size in sizes.split()
}
DEPTH = {(0, 1), (0, 5), (1, 5), (1, 25), (1, 30), (1, 50), (1, 60)}


def parse(sections: Any, node: str = "/ml2_receiver") -> Config:
    return parse_config(yaml.safe_dump({node: {"ros__parameters": sections}}).encode())


def problems(text: str | bytes) -> list[Problem]:
    data = text.encode() if isinstance(text, str) else text
    with pytest.raises(ConfigError) as raised:
        parse_config(data)
    return list(raised.value.problems)


def wrong(section: str) -> Problem:
    """The one problem of a file whose third line is `section`."""
    (problem,) = problems(f"/ml2_receiver:\n  ros__parameters:\n    {section}\n")
    assert problem.line == 3
    return problem


def test_the_file_of_the_system_it_replaces_loads_unchanged() -> None:
    config = load_config(THESIS)
    assert (config.prefix, config.requests) == ("/magic_leap2", {})


def test_enabling_everything_in_that_file_asks_for_its_sensors() -> None:
    text = THESIS.read_text("utf-8").replace("enabled: false", "enabled: true")
    requests = parse_config(text.encode()).requests
    cameras = {"color", "depth", "world_center", "world_left", "world_right"}
    cameras |= {f"eye_{place}" for place in ("nasal_left", "nasal_right")}
    cameras |= {f"eye_{place}" for place in ("temple_left", "temple_right")}
    places = ("left", "right", "compute_pack")
    imus = {f"{sensor}_{place}" for sensor in ("accel", "gyro") for place in places}
    assert set(requests) == cameras | imus | {"light_sensor", "tf"}
    assert requests["color"] == {
        "stream": 0,
        "resolution_width": 1920,
        "resolution_height": 1080,
        "update_rate": 30,
        "format": "jpeg",
        "bit_rate_mbit": 10,
        "camera_id": 1,
        "backend": "camera2",
    }


def test_the_packaged_file_starts_a_camera_and_the_inertial_units() -> None:
    requests = load_config(ROOT / "config/config.yaml").requests
    assert {"world_center", "accel_left", "gyro_compute_pack", "light_sensor"} < set(requests)
    assert not any(stream.startswith("eye_") for stream in requests)


@pytest.mark.parametrize("node", ["/ml2_receiver", "/config_ML_node", "/**"])
def test_a_key_that_is_left_out_means_what_the_packaged_file_says(node: str) -> None:
    file = ROOT / "config/config.yaml"
    packaged = yaml.safe_load(file.read_text("utf-8"))["/ml2_receiver"]["ros__parameters"]
    expected = load_config(file).values
    shown = [(section, key) for section, keys in packaged.items() for key in keys]
    assert [".".join(it) for it in shown] == list(expected), "the file shows every key"
    assert parse({}, node).values == expected
    for section, left_out in shown:
        rest = {key: value for key, value in packaged[section].items() if key != left_out}
        assert parse({**packaged, section: rest}, node).values == expected, (section, left_out)


def test_the_short_file_of_the_readme_means_compressed_images_and_inertial_units() -> None:
    readme = (ROOT / "host_receiver/README.md").read_text("utf-8")
    text = readme.partition("```yaml\n")[2].partition("```")[0]
    config = parse_config(text.encode())
    cameras = {id for id, it in config.requests.items() if "format" in it}
    assert {id: config.requests[id]["format"] for id in cameras} == dict.fromkeys(cameras, "jpeg")
    assert cameras == {"world_center", "world_left", "color"}
    assert {"accel_left", "gyro_compute_pack", "light_sensor"} < set(config.requests)


def test_the_demo_file_starts_everything_that_goes_together() -> None:
    requests = load_config(ROOT / "config/demo.yaml").requests
    table = yaml.safe_load((ROOT / "config/streams.yaml").read_text("utf-8"))
    assert set(table["streams"]) - set(requests) == {
        *("mixed_reality", "infra", "custom", "markers", "map"),
    }
    assert requests["color"]["resolution_height"] == 1080
    assert requests["depth"]["format"] == "depth16"
    assert requests["world_left"]["format"] == requests["eye_nasal_left"]["format"] == "jpeg"
    assert (requests["depth"]["stream"], requests["depth"]["update_rate"]) == (1, 30)


def test_sections_choose_between_streams_that_exclude_each_other() -> None:
    assert (
        "mixed_reality"
        in parse(
            {"picture_center": {"enabled": True, "stream": 1, "resolution_width": 1440}}
        ).requests
    )
    assert "infra" in parse({"depth_center": {"enabled": True, "format": "DepthRaw"}}).requests
    depth16 = parse({"depth_center": {"enabled": True, "format": "depth16"}}).requests
    assert depth16["depth"]["format"] == "depth16"


def test_values_of_another_section_travel_with_the_streams_that_need_them() -> None:
    requests = parse(
        {"other_sensors": {"enabled": True}, "imu": {"angular_velocity_variance": 1e-4}}
    ).requests
    assert requests["gyro_left"] == {"angular_velocity_variance": 1e-4}
    assert requests["accel_left"] == {"linear_acceleration_variance": 0}
    assert requests["tf"] == {"layout": "flat"}
    assert requests["light_sensor"] == {}


def test_without_any_stream_there_is_no_transform_tree() -> None:
    assert only_config("tf: {layout: rig}").requests == {}


@pytest.mark.parametrize(
    "node",
    [
        *("/ml2_receiver", "ml2_receiver", "/config_ML_node", "/**", "/*"),
        *("/robot1/ml2_receiver", "/**/ml2_receiver", "/*/ml2_receiver", "/robot1/**"),
    ],
)
def test_node_names_are_those_of_parameter_files(node: str) -> None:
    text = f"{node}:\n  ros__parameters:\n    gaze: {{enabled: true}}\n"
    assert "gaze" in parse_config(text.encode()).requests


def test_namespaces_may_be_mappings() -> None:
    text = "robot1: {arm: {ml2_receiver: {ros__parameters: {gaze: {enabled: true}}}}}"
    assert "gaze" in parse_config(text.encode()).requests


def test_what_is_for_another_node_is_left_out() -> None:
    """ROS does so; the same file may be given to several nodes."""
    text = """
/camera_driver: {ros__parameters: {exposure: [1, 2], gaze: {enabled: 7}}}
arm: {controller: {ros__parameters: {rate: 50}}}
/ml2_receiver: {ros__parameters: {gaze: {enabled: true}}}
"""
    config = parse_config(text.encode())
    assert "gaze" in config.requests
    assert config.ignored == ()


def test_of_a_value_for_the_node_and_one_for_all_nodes_the_last_one_holds() -> None:
    """As in ROS, for which the same file can be given."""
    own, all_nodes = (
        f"{node}: {{ros__parameters: {{gaze: {{enabled: {value}}}, battery: {{enabled: true}}}}}}"
        for node, value in (("/ml2_receiver", "true"), ("/**", "false"))
    )
    assert "gaze" in parse_config(f"{all_nodes}\n{own}".encode()).requests
    requests = parse_config(f"{own}\n{all_nodes}".encode()).requests
    assert "gaze" not in requests
    assert "battery" in requests


FLEET = """
/**: {ros__parameters: {gaze: {enabled: true}, general: {link: 10}}}
/robot1/ml2_receiver: {ros__parameters: {battery: {enabled: true}, general: {link: 20}}}
/robot2/ml2_receiver: {ros__parameters: {controller: {enabled: true}, general: {link: 30}}}
/robot2/*: {ros__parameters: {hands: {enabled: true}}}
"""


@pytest.mark.parametrize(
    ("node", "link", "streams"),
    [
        ("/robot1/ml2_receiver", 20, {"gaze", "battery"}),
        ("/robot2/ml2_receiver", 30, {"gaze", "controller", "hand_left"}),
        ("/robot2/headset", 30, {"gaze", "controller", "hand_left"}),
        ("/robot3/ml2_receiver", 10, {"gaze"}),
        ("/ml2_receiver", 10, {"gaze"}),
    ],
)
def test_a_receiver_takes_what_ros_would_of_a_file_for_several(
    node: str, link: float, streams: set[str]
) -> None:
    config = parse_config(FLEET.encode(), node=node)
    assert config.values["general.link"] == link
    known = {"gaze", "battery", "controller", "hand_left"}
    assert known & set(config.requests) == streams
    others = ["/robot1/ml2_receiver", "/robot2/ml2_receiver"] if link == 10 else []
    assert [it.key for it in config.ignored] == others


@pytest.mark.parametrize(
    ("node", "path", "is_taken"),
    [
        ("/ml2_receiver", "/*", True),
        ("/robot1/ml2_receiver", "/*", False),
        ("/robot1/ml2_receiver", "/*/ml2_receiver", True),
        ("/ml2_receiver", "/**/ml2_receiver", True),
        ("/ml2_receiver", "/robot1/**", False),
        ("/robot1/ml2_receiver", "/robot1/**", True),
        ("/robot1/ml2_receiver", "/robot1/*", True),
        ("/robot2/ml2_receiver", "/robot1/ml2_receiver", True),
        ("/robot1/headset", "/config_ML_node", True),
        ("/robot1/headset", "/robot1/headset", True),
    ],
)
def test_wildcards_are_those_of_ros_and_a_file_for_one_receiver_is_for_any(
    node: str, path: str, is_taken: bool
) -> None:
    text = f"{path}: {{ros__parameters: {{gaze: {{enabled: true}}}}}}"
    if is_taken:
        assert "gaze" in parse_config(text.encode(), node=node).requests
        return
    with pytest.raises(ConfigError, match=f"unknown node; expected one of {node}, /"):
        parse_config(text.encode(), node=node)


def test_a_section_under_a_wildcard_may_be_another_nodes() -> None:
    config = parse_config(b"/**: {ros__parameters: {planner: {speed: 1}, gaze: {enabled: true}}}")
    assert "gaze" in config.requests
    (ignored,) = config.ignored
    assert (ignored.line, ignored.key) == (1, "planner")
    assert "no section of this node" in ignored.message
    (problem,) = problems("/**: {ros__parameters: {gaze: {enable: true}}}")
    assert "did you mean enabled?" in problem.message


def test_two_receivers_in_one_file_are_told_apart_by_nobody() -> None:
    block = "{ros__parameters: {gaze: {enabled: true}}}"
    (problem,) = problems(f"/robot1/ml2_receiver: {block}\n/robot2/ml2_receiver: {block}\n")
    assert problem.line == 2
    assert "expected one receiver, found /robot2/ml2_receiver and /robot1/" in problem.message


def test_what_ros_declares_itself_is_ignored_and_said_once() -> None:
    qos = "qos_overrides: {/magic_leap2/log: {publisher: {depth: 3}}, /tf: {publisher: {}}}"
    text = f"/ml2_receiver: {{ros__parameters: {{use_sim_time: false, {qos}, gaze: {{}}}}}}"
    assert [it.key for it in parse_config(text.encode()).ignored] == [
        "use_sim_time",
        "qos_overrides",
    ]


def test_a_mode_in_a_file_stands_for_three_keys() -> None:
    config = parse({"picture_center": {"enabled": True, "mode": "1280x720@30"}})
    assert config.requests["color"]["resolution_height"] == 720
    assert wrong("picture_center: {mode: 1280x720}").message.startswith(
        "expected WIDTHxHEIGHT@RATE"
    )
    same = {"mode": "1280x720@30", "update_rate": 30}
    assert parse({"picture_center": same}).values["picture_center.resolution_width"] == 1280


@pytest.mark.parametrize("order", [("mode", "update_rate"), ("update_rate", "mode")])
def test_a_mode_and_a_key_that_contradict_are_refused(order: tuple[str, str]) -> None:
    given = {"mode": "1280x720@30", "update_rate": 15}
    text = ", ".join(f"{key}: {given[key]}" for key in order)
    problem = wrong(f"picture_center: {{{text}}}")
    assert problem.key == "picture_center.mode"
    assert "picture_center.update_rate is 15: give one of them" in problem.message


def test_keys_may_be_written_with_dots() -> None:
    assert parse({"general.topic_name": "/lab/ml2"}).prefix == "/lab/ml2"


@pytest.mark.parametrize("name", ["/a", "a", "/a/b_1", "/_x/Y"])
def test_the_prefix_gets_its_leading_slash(name: str) -> None:
    assert parse({"general": {"topic_name": name}}).prefix == "/" + name.lstrip("/")


@pytest.mark.parametrize(
    "name", ["", "/", "/a/", "a//b", "/1a", "/a b", "/a__b", "/ä", "/a-b", "/" + "a" * 200, "~/a"]
)
def test_what_ros_does_not_take_as_a_topic_is_refused(name: str) -> None:
    with pytest.raises(ConfigError, match="topic_name: expected a topic name"):
        parse({"general": {"topic_name": name}})


@pytest.mark.parametrize(
    ("value", "link"),
    [
        ("auto", Link(adapts=True)),
        ("fixed", None),
        (100, Link(adapts=True, most_mbit_per_s=100.0)),
        (0.5, Link(adapts=True, most_mbit_per_s=0.5)),
        ("100", Link(adapts=True, most_mbit_per_s=100.0)),
        ("2.5", Link(adapts=True, most_mbit_per_s=2.5)),
    ],
)
def test_the_link_is_a_word_or_a_number_of_mbit_per_s(
    value: str | float, link: Link | None
) -> None:
    assert parse({"general": {"link": value}}).link == link


def test_an_app_may_use_the_names_that_the_file_lists_and_by_default_none() -> None:
    config = parse({"app": {"subscribe": ["/robot/*", "/tf"], "call": "/robot/stop", "offer": []}})
    rules = AppRules(NameRules(("/robot/*", "/tf")), call=NameRules(("/robot/stop",)))
    assert config.app == rules
    assert parse({"battery": {"enabled": True}}).app == AppRules()


def test_an_app_offers_services_below_its_own_names_without_a_rule() -> None:
    file = {"custom": {"enabled": True}, "app": {"offer": "/robot/stop"}}
    for receiver, prefix in (("", "/magic_leap2"), ("robot1", "/robot1/magic_leap2")):
        rules = replace(parse(file), name=receiver).app
        for name in ("/robot/stop", f"{prefix}/custom/stop", f"{prefix}/custom/arm/stop"):
            assert rules.forbidden("service", name) is None
        for tail in ("stop", "customs/stop", "custom/_stop", "world_left/custom/stop"):
            name = f"{prefix}/{tail}"
            assert rules.forbidden("service", name) == f"no rule in app.offer has {name}"
        for kind in ("subscription", "publisher", "client"):
            assert rules.forbidden(kind, f"{prefix}/custom/stop") is not None
    assert parse({"app": {"offer": "/a"}}).app.forbidden("service", "/magic_leap2/custom/stop")


@pytest.mark.parametrize(
    "names", [["robot"], ["/two words"], [1], [["/a"]], ["/a/b*"], {"a": "/b"}, ["/a"] * 65, "a"]
)
def test_what_is_no_list_of_names_is_refused(names: object) -> None:
    with pytest.raises(ConfigError, match="expected a list of at most 64 absolute names"):
        parse({"app": {"subscribe": names}})


@pytest.mark.parametrize(
    "key", ["general.topic_name", "world_left.calibration", "world_left.format"]
)
def test_a_list_is_no_value_of_another_key(key: str) -> None:
    with pytest.raises(ConfigError, match="found a list"):
        parse({key: ["/a"]})


def test_images_give_way_to_the_link_unless_told_otherwise() -> None:
    assert parse({"gaze": {"enabled": True}}).link == Link(adapts=True)
    assert load_config(THESIS).link == Link(adapts=True)


LINK = "general.link"
LINKS = "auto, fixed, or a number of Mbit/s above 0"


@pytest.mark.parametrize(
    ("section", "key", "value", "allowed"),
    [
        ("general: {link: fast}", LINK, "fast", LINKS),
        ("general: {link: 0}", LINK, "0", LINKS),
        ("general: {link: -1}", LINK, "-1", LINKS),
        ("general: {link: .inf}", LINK, ".inf", LINKS),
        ('general: {link: "nan"}', LINK, '"nan"', LINKS),
        ('general: {link: "1e999"}', LINK, '"1e999"', LINKS),
        ('general: {link: "0"}', LINK, '"0"', LINKS),
        ("general: {link: true}", LINK, "true", LINKS),
        ("general: {link: }", LINK, "nothing", LINKS),
        ("general: {link: [100]}", LINK, "a list", LINKS),
        ('gaze: {enabled: "true"}', "gaze.enabled", '"true"', "true or false"),
        ("gaze: {enabled: 1}", "gaze.enabled", "1", "true or false"),
        ("gaze: {enabled: }", "gaze.enabled", "nothing", "true or false"),
        ("gaze: {enabled: [true]}", "gaze.enabled", "a list", "true or false"),
        ("gaze: {enabled: {a: b}}", "gaze.enabled", "a mapping", "true or false"),
        ("gaze: {enabled: !!bool maybe}", "gaze.enabled", "maybe", "true or false"),
        ("gaze: {enable: true}", "gaze.enable", "true", "did you mean enabled?"),
        ("gaze: true", "gaze", "true", "keys under it"),
        ("gaze:", "gaze", "nothing", "keys under it"),
        ("gazes: {enabled: true}", "gazes", "true", "did you mean gaze?"),
        ("general: {topic_name: 5}", "general.topic_name", "5", "/magic_leap2"),
        ("general: {topic_name: yes}", "general.topic_name", "yes", "/magic_leap2"),
        ("tf: {layout: tree}", "tf.layout", "tree", "flat, rig"),
        ("depth_center: {format: no}", "depth_center.format", "no", "Depth32, DepthRaw"),
        ("depth_center: {update_rate: 24}", "depth_center.update_rate", "24", "5, 25, 30, 50, 60"),
        ("depth_center: {update_rate: 030}", "depth_center.update_rate", "030", "5, 25, 30, 50"),
        ("depth_center: {update_rate: 30.0}", "depth_center.update_rate", "30.0", "5, 25, 30"),
        ("depth_center: {update_rate: true}", "depth_center.update_rate", "true", "5, 25, 30"),
        ('world_left: {stream: "0"}', "world_left.stream", '"0"', "0, 1"),
        ("world_left: {stream: 2}", "world_left.stream", "2", "0, 1"),
        ("world_left: {stream: false}", "world_left.stream", "false", "0, 1"),
        ("gazes: {enabled: true, color: red}", "gazes", "true", "did you mean gaze?"),
        (
            "world_left: {format: png}",
            "world_left.format",
            "png",
            "Grayscale, h264, h264_foxglove, jpeg",
        ),
        (
            "depth_center: {format: jpeg}",
            "depth_center.format",
            "jpeg",
            "Depth32, DepthRaw, depth16",
        ),
        ("picture_center: {format: depth16}", "picture_center.format", "depth16", "jpeg"),
        ("world_left: {quality: 0}", "world_left.quality", "0", "from 1 to 100"),
        ("eye_nasal_left: {quality: 101}", "eye_nasal_left.quality", "101", "from 1 to 100"),
        ("world_left: {quality: 80.0}", "world_left.quality", "80.0", "from 1 to 100"),
        ("world_left: {quality: true}", "world_left.quality", "true", "from 1 to 100"),
        ("picture_center: {quality: 80}", "picture_center.quality", "80", "unknown key"),
        ("imu: {angular_velocity_variance: -1}", "imu.angular_velocity_variance", "-1", "least 0"),
        ("imu: {angular_velocity_variance: .nan}", "imu.angular_velocity_variance", ".nan", "0"),
        ("imu: {angular_velocity_variance: 1e999}", "imu.angular_velocity_variance", "1e999", "0"),
        ("imu: {angular_velocity_variance: on}", "imu.angular_velocity_variance", "on", "0"),
        ("picture_center: {camera_id: 2}", "picture_center.camera_id", "2", "0, 1"),
        ("picture_center: {camera_id: true}", "picture_center.camera_id", "true", "0, 1"),
        ('picture_center: {camera_id: "1"}', "picture_center.camera_id", '"1"', "0, 1"),
        ("markers: {type: aruco, dictionary: 36h11}", "markers.dictionary", "36h11", "5X5_100"),
        ("markers: {type: aruco}", "markers.dictionary", "36h11 (the default)", "5X5_100"),
        ("markers: {dictionary: 5X5_100}", "markers.dictionary", "5X5_100", "36h10, 36h11 with"),
        ("markers: {size_m: 0}", "markers.size_m", "0", "least 0.01"),
        (f"map: {{localize: {'é' * 32}}}", "map.localize", "é" * 32, "63 bytes in one line"),
        ("<<: {a: b}", "<<", "b", "gaze"),
    ],
)
def test_a_wrong_value_is_one_error_with_key_value_line_and_what_is_allowed(
    section: str, key: str, value: str, allowed: str
) -> None:
    problem = wrong(section)
    assert (problem.key, problem.value) == (key, value)
    assert allowed in problem.message


def test_markers_beside_the_camera_that_excludes_them_name_the_one_that_does_not() -> None:
    (problem,) = problems(only("picture_center: {enabled: true}, markers: {enabled: true}"))
    assert (problem.line, problem.key, problem.value) == (6, "markers.enabled", "true")
    assert "give picture_center.camera_id 0" in problem.message
    settings = Settings.of(only_config("markers: {enabled: true}"))
    with pytest.raises(ConfigError, match=r"give picture_center\.camera_id 0"):
        settings.changed({"picture_center.enabled": True})


@pytest.mark.parametrize(
    "camera",
    ["{enabled: true, camera_id: 0}", "{enabled: true, backend: openxr}", "{}", MIXED],
)
def test_markers_go_with_the_cameras_that_do_not_exclude_them(camera: str) -> None:
    sections = f"markers: {{enabled: true, type: qr}}, picture_center: {camera}"
    assert only_config(sections).requests["markers"]["type"] == "qr"


@pytest.mark.parametrize("yes", ["true", "True", "yes", "on"])
def test_what_ros_reads_as_true_is_true(yes: str) -> None:
    text = f"/ml2_receiver: {{ros__parameters: {{gaze: {{enabled: {yes}}}}}}}"
    assert "gaze" in parse_config(text.encode()).requests


@pytest.mark.parametrize("number", ["1e-3", "1.0e-3", "0.001", "+1E-3"])
def test_numbers_may_have_an_exponent_without_a_point(number: str) -> None:
    text = (
        "/ml2_receiver: {ros__parameters: {imu: {united: true, linear_acceleration_variance: %s}}}"
    )
    requests = parse_config((text % number).encode()).requests
    assert requests["imu_left"]["linear_acceleration_variance"] == 0.001


def test_width_and_height_are_wrong_together_in_one_error() -> None:
    problem = wrong("picture_center: {resolution_width: 1921, resolution_height: 1081}")
    assert problem.value == "1921x1081"
    assert "1920x1080" in problem.message
    assert "648x720" not in problem.message, "that one is of stream 1"


def test_a_default_that_no_longer_fits_is_reported_where_it_was_broken() -> None:
    problem = wrong("picture_center: {stream: 1}")
    assert problem.key == "picture_center.resolution_width"
    assert "1920x1080 (the default)" in problem.message


def test_disabled_sensors_are_checked_too() -> None:
    assert wrong("world_left: {enabled: false, update_rate: 60}").key == "world_left.update_rate"


def test_a_key_given_twice_names_both_lines() -> None:
    (problem,) = problems(
        "/**:\n  ros__parameters:\n    gaze:\n      enabled: true\n      enabled: false\n"
    )
    assert (problem.line, problem.key, problem.value) == (5, "gaze.enabled", "false")
    assert "line 4" in problem.message


def test_a_section_given_twice_is_found_by_its_keys() -> None:
    (problem,) = problems(
        "/**:\n  ros__parameters:\n    gaze: {enabled: true}\n    gaze.enabled: false\n"
    )
    assert problem.line == 4


def test_all_errors_come_together_in_the_order_of_their_lines() -> None:
    found = problems(
        "/ml2_receiver:\n"
        "  ros__parameters:\n"
        "    gaze: {enabled: 3}\n"
        "    picture_center:\n"
        "      stream: 1\n"
        "      resolution_width: 1944\n"
        "      resolution_height: 2160\n"
        "      update_rate: 60\n"
        "      format: png\n"
        "      colour: red\n"
        "    hand: {enabled: true}\n"
    )
    assert [(problem.line, problem.key) for problem in found] == [
        (3, "gaze.enabled"),
        (8, "picture_center.update_rate"),
        (9, "picture_center.format"),
        (10, "picture_center.colour"),
        (11, "hand"),
    ]
    assert "expected update_rate to be one of 30 with stream 1, 1944x2160" in found[1].message


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("", 1, "an empty file"),
        ("# nothing but a comment\n", 1, "an empty file"),
        ("- a\n- b\n", 1, "found a list"),
        ("a\n", 1, "found a"),
        ("{}", 1, "found an empty mapping"),
        ("/ml2_receiver: {}", 1, "expected ros__parameters: under it, found an empty mapping"),
        ("a: b\n", 1, "unknown node"),
        ("/ml2_receivr:\n  ros__parameters: {}\n", 1, "did you mean ml2_receiver?"),
        ("\n/ml2_receiver: 1\n", 2, "expected ros__parameters"),
        ("/ml2_receiver:\n  parameters: {}\n", 2, "expected ros__parameters"),
        ("/ml2_receiver:\n  ros__parameters:\n", 2, "expected sections under it, found nothing"),
        ("? [a]\n: b\n", 1, "unknown node"),
        ("a: b\n\nc: [\n", 4, "not valid YAML"),
        ("a:\n\tb: c\n", 2, "not valid YAML"),
        ("a: 1\n---\nb: 1\n", 2, "single document"),
        ("a: &x 1\nb: *x\nc: 1\n", 2, "alias"),
        ("a: 1\nb: \x01\n", 2, "not valid YAML"),
        ("a: !<tag:x> b", 1, "unknown node"),
        ('"\\UFFFFFFFF"', 0, "not valid YAML"),
        (b"a: 1\nb: \xff\n", 2, "expected UTF-8, found the byte 0xff"),
        ("[" * 60_000, 0, "nested too deeply"),
        ("#" * 70_000, 0, "expected at most 65536 bytes"),
    ],
)
def test_a_file_that_is_no_parameter_file_says_where(
    text: str | bytes, line: int, message: str
) -> None:
    (problem,) = problems(text)
    assert problem.line == line
    assert message in problem.message


def test_text_that_a_terminal_would_act_on_is_escaped() -> None:
    problem = wrong('tf: {layout: "\\e[31m"}')
    assert problem.value == '"\\x1b[31m"'


@pytest.mark.parametrize("place", ["missing.yaml", "."])
def test_a_file_that_cannot_be_read_says_why(tmp_path: Path, place: str) -> None:
    with pytest.raises(ConfigError, match=f"^{tmp_path / place}: cannot be read: "):
        load_config(tmp_path / place)


@given(
    stream=st.sampled_from([0, 1, 2]),
    size=st.sampled_from(sorted({size for _, size, _ in COLOR} | {(1920, 720), (0, 0)})),
    rate=st.sampled_from([1, 15, 30, 60]),
)
def test_a_colour_mode_is_accepted_exactly_when_the_device_has_it(
    stream: int, size: tuple[int, int], rate: int
) -> None:
    width, height = size
    values = {"stream": stream, "resolution_width": width, "resolution_height": height}
    sections = {"picture_center": values | {"update_rate": rate, "enabled": True}}
    if (stream, size, rate) in COLOR:
        request = parse(sections).requests["mixed_reality" if stream else "color"]
        others = {"update_rate": rate, "format": "jpeg", "bit_rate_mbit": 10, "backend": "camera2"}
        others |= {} if stream else {"camera_id": 1}
        assert request == values | others
    else:
        with pytest.raises(ConfigError):
            parse(sections)


@pytest.mark.parametrize(
    ("stream", "rate"), list(itertools.product([0, 1], [1, 5, 15, 25, 30, 50, 60]))
)
def test_a_depth_mode_is_accepted_exactly_when_the_device_has_it(stream: int, rate: int) -> None:
    sections = {"depth_center": {"stream": stream, "update_rate": rate}}
    if (stream, rate) in DEPTH:
        parse(sections)
    else:
        with pytest.raises(ConfigError):
            parse(sections)


SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8)
NAMES = (
    st.sampled_from(
        ["gaze", "imu", "general", "link", "tf", "depth_center", "enabled", "stream", "a.b"]
    )
    | st.text()
)
TREES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=4)
)


def problems_or_none(data: bytes) -> tuple[Problem, ...]:
    try:
        parse_config(data)
    except ConfigError as error:
        str(error).encode("utf-8")  # can be printed
        return error.problems
    return ()


@given(TREES)
def test_any_tree_is_a_configuration_or_a_configuration_error(tree: Any) -> None:
    document = {"/ml2_receiver": {"ros__parameters": tree}}
    found = problems_or_none(yaml.safe_dump(document).encode())
    assert all(problem.line >= 1 for problem in found)


@given(st.binary() | st.text(alphabet="a1:-?*&!|>%@`'\"{}[]<,. \n\t~\\#é\0").map(str.encode))
def test_bytes_that_are_no_parameter_file_are_a_configuration_error(data: bytes) -> None:
    assert problems_or_none(data)


@given(st.data())
def test_a_damaged_file_is_a_configuration_or_a_configuration_error(data: st.DataObject) -> None:
    text = (ROOT / "config/config.yaml").read_bytes()
    start = data.draw(st.integers(0, len(text)))
    end = data.draw(st.integers(start, min(len(text), start + 40)))
    problems_or_none(text[:start] + data.draw(st.binary(max_size=4)) + text[end:])

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from command_line import refusal
from configurations import only
from ml2_receiver.cli import main

ROOT = Path(__file__).resolve().parents[2]

type Check = Callable[..., Any]


def test_a_good_file_lists_the_topics_it_starts(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["config", "check", str(ROOT / "config/config.yaml")]) == 0
    printed = capsys.readouterr()
    assert "/magic_leap2/world_center/image_raw" in printed.out
    assert "9 streams; images need about 34 Mbit/s" in printed.out
    (camera,) = [line for line in printed.out.splitlines() if "world_center/image_raw" in line]
    assert "34.1" in camera
    assert "/tf" in printed.out
    assert "world_left" not in printed.out
    assert printed.err == ""


@pytest.fixture
def check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Check:
    """Checks a file of these words; returns what is printed."""

    def checked(text: str, *options: str, code: int = 0) -> Any:
        file = tmp_path / "config.yaml"
        file.write_text(text)
        assert main(["config", "check", str(file), *options]) == code
        return capsys.readouterr()

    return checked


def test_topics_that_are_switched_off_are_not_listed(check: Check) -> None:
    depth = "depth_center: {enabled: true, flags: true}"
    printed = check(only(f"general: {{topic_name: /lab}}, {depth}")).out
    assert "/lab/depth/flags" in printed
    assert "confidence" not in printed


def test_what_is_for_another_node_is_said(tmp_path: Path, check: Check) -> None:
    printed = check(
        "/**:\n  ros__parameters:\n    planner: {speed: 1}\n    gaze: {enabled: true}\n"
    )
    assert "gaze" in printed.out
    said = f"{tmp_path / 'config.yaml'}:3: planner: ignored, since it is no section of this node"
    assert printed.err.startswith(said)


FLEET = """
/**: {ros__parameters: {planner: {speed: 1}, gaze: {enabled: true}, world_center: {enabled: false}}}
/robot1/ml2_receiver: {ros__parameters: {controller: {enabled: true}}}
robot2: {ml2_receiver: {ros__parameters: {hands: {enabled: true}, gaze: {enabled: VALUE}}}}
/camera_driver: {ros__parameters: {rate: 30}}
"""


def test_a_file_for_several_receivers_is_checked_for_each(check: Check) -> None:
    file = FLEET.replace("VALUE", "false")
    printed = check(file)
    assert "/robot1/ml2_receiver: " in printed.out
    assert "/robot2/magic_leap2/hand_left" in printed.out
    assert printed.err.count("planner") == 1
    each = json.loads(check(file, "--json").out)
    assert list(each) == ["/robot1/ml2_receiver", "/robot2/ml2_receiver"]
    first, second = (it["streams"] for it in each.values())
    assert "/robot1/magic_leap2/gaze" in first["gaze"]["topics"]
    assert {"gaze", "controller"} <= first.keys()
    assert "hand_left" not in first
    assert "hand_left" in second
    assert not {"gaze", "controller"} & second.keys()


def test_what_is_wrong_for_one_of_several_receivers_is_said_once(check: Check) -> None:
    file = FLEET.replace("speed", "sp").replace("gaze: {enabled: true}", "gaze: {enable: true}")
    *said, _ = check(file.replace("VALUE", "maybe"), code=2).err.splitlines()
    assert [it.split(":")[1:3] for it in said] == [["2", " gaze.enable"], ["4", " gaze.enabled"]]


def test_a_bad_file_has_one_line_per_error(tmp_path: Path, check: Check) -> None:
    file = tmp_path / "config.yaml"
    text = "/**:\n  ros__parameters:\n    gaze: {enabled: 1}\n    tf: {layout: tree}\n"
    printed = check(text, code=2)
    assert printed.out == ""
    assert printed.err.splitlines() == [
        f"{file}:3: gaze.enabled: expected true or false, found 1",
        f"{file}:4: tf.layout: expected one of flat, rig, found tree",
        "hint: `ml2-receiver config show` lists every section, key and legal value.",
    ]


def test_a_missing_file_is_one_error() -> None:
    said = refusal("config", "check", "/no/such/file.yaml")
    assert said == "/no/such/file.yaml: cannot be read: No such file or directory\n"


def test_a_good_file_is_told_to_scripts(check: Check) -> None:
    told = json.loads(check(only("world_left: {enabled: true}"), "--json").out)
    assert told["prefix"] == "/magic_leap2"
    assert "/magic_leap2/world_left/image_raw" in told["streams"]["world_left"]["topics"]
    assert told["streams"]["world_left"]["values"]["update_rate"] == 30
    assert told["streams"]["world_left"]["mbit_per_s"] == told["mbit_per_s"] == 247.74
    assert told["streams"]["tf"]["mbit_per_s"] is None
    assert list(told["streams"]) == ["world_left", "tf"]


JPEG = {"world_left.format": "jpeg"}
SET_JPEG = "run `ml2-receiver set world_left.format=jpeg`: images then need about 34 Mbit/s"
GIVE_WAY = "leave it to the headset, which lowers"


@pytest.mark.parametrize(
    ("general", "options", "words", "link", "change"),
    [
        ("", [], "", None, None),
        ("", ["--link", "300"], ", within the link's 300", 300, {}),
        ("", ["--link", "99.5"], f", more than the link's 99.5: {SET_JPEG}", 99.5, JPEG),
        ("general: {link: 300}, ", [], ", within the link's 300", 300, {}),
        (
            *("general: {link: 300}, ", ["--link", "99.5"]),
            *(f", more than the link's 99.5: {SET_JPEG}", 99.5, JPEG),
        ),
        ("", ["--link", "5"], f", more than the link's 5: {GIVE_WAY}", 5, None),
    ],
)
def test_a_file_is_compared_with_what_the_link_carries(
    check: Check,
    general: str,
    options: list[str],
    words: str,
    link: float | None,
    change: dict[str, str] | None,
) -> None:
    text = only(f"{general}world_left: {{enabled: true}}")
    first = check(text, *options).out.splitlines()[0]
    assert first.startswith(f"2 streams; images need about 248 Mbit/s{words}")
    told = json.loads(check(text, "--json", *options).out)
    assert (told["link_mbit_per_s"], told["change"]) == (link, change)


@pytest.mark.parametrize("link", ["abc", "0", "-5", "nan", "inf", ""])
def test_a_link_is_a_rate_above_0(link: str) -> None:
    assert f"expected a number above 0, found '{link}'" in refusal(
        "config", "check", "config.yaml", "--link", link
    )


def test_every_stream_of_the_file_is_shown_with_its_legal_values(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["config", "show", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    file = yaml.safe_load((ROOT / "config/streams.yaml").read_text())
    assert shown.keys() == file["streams"].keys()
    assert shown["depth"]["when"] == {
        "depth_center.enabled": True,
        "depth_center.format": ["Depth32", "depth16"],
    }
    assert [mode["update_rates"] for mode in shown["depth"]["modes"]] == [
        [1, 5],
        [5, 25, 30, 50, 60],
    ]
    assert {mode["stream"] for mode in shown["mixed_reality"]["modes"]} == {1}
    assert shown["depth"]["keys"]["depth_center.confidence"]["type"] == "bool"
    assert shown["gyro_left"]["keys"]["imu.angular_velocity_variance"]["minimum"] == 0
    quality = shown["world_left"]["keys"]["world_left.quality"]
    assert (quality["minimum"], quality["maximum"]) == (1, 100)
    assert shown["world_left"]["keys"]["world_left.backend"]["allowed"] == ["sdk", "openxr"]


def test_people_get_a_table_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["config", "show"]) == 0
    table = capsys.readouterr().out
    for word in (
        "world_left",
        "1 to 100",
        "Depth32 or depth16",
        "1016x1016",
        "depth_center.radial",
        "any other runs",
        "general.link: auto,",
        "Mbit/s above 0",
        "publish.lazy: true,",
    ):
        assert word in table

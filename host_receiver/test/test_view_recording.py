"""`ml2-receiver view FOLDER`, as a browser sees it."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import recorded_room
from bag_scene import new_writer, tf, written
from command_line import refusal
from ml2_receiver.cli import main
from ml2_tools.viewing.recorded_source import RecordedSource
from recorded_room import BEGIN_NS, EYE_S, HZ, LENGTH_S, grey
from ros_processes import Child
from viewing_browser import Browser, Picture, View


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded_room.write(tmp_path_factory.mktemp("bags") / "room")


@pytest.fixture(scope="module")
def view(room: Path) -> Iterator[View]:
    with View(str(room)) as view:
        yield view


@pytest.fixture
def browser(view: View) -> Iterator[Browser]:
    """A browser that shows the recording, which stands still at its beginning."""
    with Browser(view.url, view.token) as browser:
        ask(browser, play=False)
        ask(browser, seek=0)
        ask(browser, speed=1)
        yield browser


def ask(browser: Browser, **request: Any) -> None:
    browser.say(**request)
    assert browser.text("answer") == {
        "type": "answer",
        "to": "recording",
        "is_done": True,
        "text": "",
    }


def await_all(browser: Browser, *wanted: Callable[[dict[str, Any] | Picture], bool]) -> None:
    """Waits for a message of each kind; the test's time limit ends an endless wait."""
    missing = list(wanted)
    while missing:
        found = browser.next()
        missing = [it for it in missing if not it(found)]


def image_of(stream: str, level: int) -> Callable[[dict[str, Any] | Picture], bool]:
    return lambda it: isinstance(it, Picture) and it.stream == stream and is_grey(it, level)


def text_of(type: str, **values: Any) -> Callable[[dict[str, Any] | Picture], bool]:
    expected = {"type": type, **values}
    return lambda it: isinstance(it, dict) and it | expected == it


def is_grey(found: Picture, level: int) -> bool:
    assert found.pixels.shape == (48, 64)
    return bool(np.abs(found.pixels.astype(int) - level).max() <= 2)


def test_its_frames_tell_the_name_of_the_receiver(room: Path, tmp_path: Path) -> None:
    assert RecordedSource(room).receiver == "robot1"
    types = {"/tf": "tf2_msgs/msg/TFMessage"}
    for number, payload in enumerate((tf(0), b"", b"\0\1" + bytes(6))):
        folder = tmp_path / str(number)
        written(folder, [("/tf", 1, payload)], types, prefix="/lab/magic_leap2")
        assert RecordedSource(folder).receiver == ""


def test_what_a_recording_is_comes_first(view: View) -> None:
    with Browser(view.url, view.token) as browser:
        hello = browser.text("hello")
        state = browser.text("state")
    assert hello["recording"]["length_s"] == LENGTH_S
    assert hello["recording"]["begin_s"] == BEGIN_NS / 1e9
    assert "controls" not in hello
    assert "clock uncertainty" not in [it["name"] for it in hello["plots"]]
    facts = {it["name"]: it["text"] for it in state["facts"]}
    assert (facts["recording"], facts["headset"]) == ("room", "device name")
    assert facts["length"] == f"{LENGTH_S} s"
    world, eye = state["streams"]
    assert (world["id"], eye["id"], eye["is_eye"]) == ("world_left", "eye_nasal_left", True)
    assert world["rate_hz"] == pytest.approx(HZ, rel=0.02)
    assert world["lost"] is None


def test_a_seek_shows_the_newest_messages_at_that_time(browser: Browser) -> None:
    browser.say(show=["world_left", "scene"])
    for at_s in (12.34, 3.99, LENGTH_S, 0):
        number = int(at_s * HZ)
        head = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, number, 0, 0, 1]
        browser.say(seek=at_s)
        await_all(
            browser,
            image_of("world_left", grey(number)),
            text_of("scene", head=head),
            text_of("position", at_s=pytest.approx(at_s), is_playing=False),
        )


def test_what_is_shown_in_a_pause_is_there_at_once_and_again(browser: Browser) -> None:
    ask(browser, seek=7)
    for _ in range(2):
        browser.say(show=["world_left"])
        await_all(browser, image_of("world_left", grey(7 * HZ)))
        browser.say(show=[])


def test_an_image_in_full_size_tells_its_pixels(browser: Browser) -> None:
    ask(browser, seek=7)
    browser.say(show=["full world_left"])
    await_all(browser, image_of("full world_left", grey(70)))
    browser.say(pixel="world_left", at=[63, 47])
    assert browser.text("pixel") == {"type": "pixel", "at": [63, 47], "value": [grey(70)]}
    browser.say(pixel="world_left", at=[64, 47])
    assert browser.text("pixel")["value"] == []
    browser.say(pixel="scene", at=[0, 0])
    assert browser.end()[0] == 1008


def test_latched_messages_are_shown_wherever_a_seek_leads(browser: Browser) -> None:
    ask(browser, seek=19)
    while not (state := browser.text("state"))["streams"][0]["mode"]:
        pass
    assert state["streams"][0]["mode"] == "1016x1016@30 Grayscale"
    facts = {it["name"]: it["text"] for it in state["facts"]}
    assert facts["battery"] == "50 %"


def test_it_plays_to_the_end_and_from_the_beginning_again(browser: Browser) -> None:
    browser.say(show=["world_left"])
    ask(browser, seek=LENGTH_S - 2)
    ask(browser, speed=4)
    ask(browser, play=True)
    seen = []
    while (position := browser.text("position"))["is_playing"] or position["at_s"] < LENGTH_S:
        seen.append(position["at_s"])
    assert seen == sorted(seen)
    assert (position["at_s"], position["rate"]) == (LENGTH_S, 4)
    ask(browser, play=True)
    while (position := browser.text("position"))["at_s"] >= LENGTH_S / 2:
        pass
    assert position["is_playing"]


def test_all_messages_are_played_in_their_order(browser: Browser) -> None:
    browser.say(show=["world_left"])
    ask(browser, play=True)
    levels = [int(np.median(found.pixels)) for found in pictures(browser, 15)]
    assert levels == sorted(levels)
    assert levels[-1] - levels[0] >= 13


def pictures(browser: Browser, count: int) -> Iterator[Picture]:
    for _ in range(count):
        yield browser.picture()


def test_nothing_is_played_before_a_browser_looks(room: Path, browser: Browser) -> None:
    with View(str(room)) as other:
        ask(browser, speed=4)
        ask(browser, play=True)
        while browser.text("position")["at_s"] < 8:
            pass
        with Browser(other.url, other.token) as first:
            position = first.text("position")
            assert (position["at_s"] < 1, position["is_playing"]) == (True, True)


def test_eye_images_need_the_option_in_a_recording_too(room: Path, view: View) -> None:
    with Browser(view.url, view.token) as browser:
        assert "eye_nasal_left" not in browser.text("hello")["images"]
        browser.say(show=["eye_nasal_left"])
        assert browser.end()[0] == 1008
    with View(str(room), "--eyes") as other, Browser(other.url, other.token) as browser:
        ask(browser, play=False)
        browser.say(show=["eye_nasal_left"])
        browser.say(seek=LENGTH_S - 1)
        await_all(browser, image_of("eye_nasal_left", grey(EYE_S[1] * HZ)))
        browser.say(seek=EYE_S[0] / 2)
        await_all(browser, text_of("image", stream="eye_nasal_left", reason=""))


@pytest.mark.parametrize(
    "request_",
    [{"call": "stop"}, {"set": "battery", "to": {"enabled": False}}, {"seek": LENGTH_S + 1}],
)
def test_a_recording_is_not_steered(view: View, request_: dict[str, Any]) -> None:
    with Browser(view.url, view.token) as browser:
        browser.say(**request_)
        assert browser.end()[0] == 1008


def test_a_damaged_part_is_said_and_the_others_are_shown(tmp_path: Path) -> None:
    folder = recorded_room.write_damaged(tmp_path / "room")
    with View(str(folder)) as view, Browser(view.url, view.token) as browser:
        browser.say(show=["world_left"])
        ask(browser, seek=LENGTH_S / 2)
        while "problem" not in (state := browser.text("state")):
            pass
        assert "is broken" in state["problem"]
        browser.say(seek=2)
        await_all(browser, image_of("world_left", grey(2 * HZ)))
        while "problem" in browser.text("state"):
            pass


def test_what_is_no_recording_is_refused_in_one_line(
    tmp_path: Path, room: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    empty, foreign = tmp_path / "empty", tmp_path / "foreign"
    new_writer(empty).close()
    foreign.mkdir()
    (foreign / "notes.mcap").write_bytes(b"none")
    without = tmp_path / "without"
    without.mkdir()
    for folder, words in {
        tmp_path / "nowhere": "cannot read",
        without: "expected .mcap files",
        empty: "has no topics",
        foreign: "not a valid MCAP file, it begins with b'none'",
    }.items():
        assert main(["view", "--no-browser", str(folder)]) == 2
        said = capsys.readouterr()
        assert said.out == ""
        error, *hints = said.err.splitlines()
        assert words in error
        assert len(hints) <= 1
    assert "--name" in refusal("view", "--name", "robot1", room)


def test_it_needs_no_ros(room: Path) -> None:
    program = """import sys; sys.modules["rclpy"] = None
from ml2_receiver.cli import main; sys.exit(main(["view", "--no-browser", sys.argv[1]]))"""
    with Child("-c", program, str(room)) as view:
        assert view.line().startswith("open http://127.0.0.1:")


def test_it_ends_with_an_interrupt(room: Path) -> None:
    with View(str(room)) as view, Browser(view.url, view.token) as browser:
        browser.text("hello")
        assert view.end() == 0
        assert browser.end()[0] == 1001

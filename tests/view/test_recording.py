"""A recording on the page: the panels, and the time line."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect
from rosbags.highlevel import AnyReader

from bags import message_counts
from images import REPORTS, await_images, keep_screens
from lab import new_page, written_config
from processes import RECEIVER, isolated_environment, line_with, process, recorded_walk
from test_page import CONTROLS

# More than 3 s have of each stream
_LEAST = 100
_STREAMS = ("color", "depth", "world_left")
_PIXELS = "() => document.querySelector('[data-stream=color] canvas').toDataURL()"
_POSITION = "() => Number(document.querySelector('#timeline input').value)"


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of the cameras of the lab, which need not run for it."""
    folder = tmp_path_factory.mktemp("recording")
    return recorded_walk(written_config(folder), folder, has_images)


def has_images(walk: Path) -> bool:
    counts = {it.split("/")[2]: n for it, n in message_counts(walk).items() if "/image_raw" in it}
    return all(counts.get(stream, 0) >= _LEAST for stream in _STREAMS)


@pytest.fixture(scope="module")
def page(browser: Browser, walk: Path) -> Iterator[Page]:
    """The page of the recording; `view` has no ROS to reach the lab with."""
    view: list[str | Path] = [RECEIVER, "view", walk, "--no-browser"]
    with process(view, isolated_environment(), walk.with_name("view.log")) as playing:
        page = new_page(browser, "light")
        page.goto(line_with(playing, "open ").split()[1])
        expect(page.locator("#facts")).to_contain_text("walk")
        yield page
        page.context.close()


def test_the_file_that_a_browser_gets_leads_to_the_page(browser: Browser, walk: Path) -> None:
    environment = isolated_environment() | {"DISPLAY": ":0", "BROWSER": "echo %s"}
    with process([RECEIVER, "view", walk], environment, walk.with_name("opened.log")) as opened:
        page = new_page(browser)
        page.goto(line_with(opened, "file:"))
        expect(page.locator("#facts")).to_contain_text("walk")
        page.context.close()


def test_the_panels_play(page: Page, walk: Path) -> None:
    rates_hz = mean_rates_hz(walk)
    for stream in _STREAMS:
        play_from_the_start(page)
        await_images(page, stream, 2)
        caption = page.locator(f"[data-stream={stream}] figcaption p")
        expect(caption.first).to_have_text(f"{rates_hz[stream]:.1f} Hz")
        for unknown in (1, 2):
            expect(caption.nth(unknown)).to_be_hidden()
        expect(caption.nth(3)).to_have_text(re.compile(r"^\d+x\d+@30 \w+$"))
    for name in ("head", "color", "hand left", "gaze"):
        expect(page.locator("#scene").get_by_role("list")).to_contain_text(name)
    expect(page.locator("#plots output").first).to_have_text(re.compile(r"x -?\d+\.\d+ y"))
    page.screenshot(path=REPORTS / "view_recording.png")
    keep_screens(page, "played")


def test_a_recording_has_no_controls_of_a_receiver(page: Page) -> None:
    for name in ("Record", "Stop streams", "Test the link"):
        expect(page.get_by_role("button", name=name, exact=True)).to_have_count(0)
    expect(page.get_by_text("Sensors and modes")).to_be_hidden()
    expect(page.locator("#facts")).not_to_contain_text("security")


def test_keys_pause_seek_and_play(page: Page, walk: Path) -> None:
    bar = page.get_by_role("group", name="Time line")
    button, slider = bar.get_by_role("button"), bar.get_by_role("slider")
    said = bar.get_by_role("status")
    # It may have come to its end.
    if button.text_content() == "Pause":
        button.press("Enter")
    expect(button).to_have_text("Play")
    slider.press("End")
    length_s = f"{length_ns(walk) / 1e9:.1f}"
    end = rf"^{length_s} of {length_s} s · \d\d:\d\d:\d\d\.\d$"
    expect(said).to_have_text(re.compile(end))
    slider.press("Home")
    expect(said).to_have_text(re.compile(r"^0\.0 of "))
    slider.press("ArrowRight")
    expect(said).to_have_text(re.compile(r"^0\.1 of "))
    first, middle_s = pixels(page), middle_image_s(walk, "color")
    slider.fill(f"{middle_s:.1f}")
    expect(said).to_have_text(re.compile(rf"^{middle_s:.1f} of "))
    page.wait_for_function(f"(first) => ({_PIXELS})() !== first", arg=first)
    bar.get_by_role("combobox").select_option("4")
    button.press("Space")
    page.wait_for_function(f"() => ({_POSITION})() > {middle_s + 0.3}")


# Decodes an image that a newer one overtakes, one that is skipped, and what is none.
_OVERTAKEN = """
async () => {
  const { ImageDecoder } = await import("./image_decoder.js");
  const decode = window.createImageBitmap, pixel = new ImageData(1, 1);
  let first;
  window.createImageBitmap = async (...given) => {
    await new Promise((done) => first ? done() : (first = done));
    return decode(...given);
  };
  const decoder = new ImageDecoder(), overtaken = decoder.decode(pixel);
  const newer = await decoder.decode(pixel);
  first();
  const left = [await overtaken];
  first = undefined;
  const skipped = decoder.decode(pixel);
  decoder.skip();
  first();
  left.push(await skipped);
  const last = await decoder.decode(new Blob(["no image"]));
  window.createImageBitmap = decode;
  return [newer.width, ...left.map((it) => it === undefined), last];
}
"""


def test_an_image_that_is_decoded_late_does_not_replace_a_newer_one(page: Page) -> None:
    assert page.evaluate(_OVERTAKEN) == [1, True, True, None]


def play_from_the_start(page: Page) -> None:
    """At the lowest speed, so that the end is not reached before a slow page has drawn images."""
    bar = page.get_by_role("group", name="Time line")
    bar.get_by_role("combobox").select_option("0.25")
    bar.get_by_role("slider").press("Home")
    if bar.get_by_role("button").text_content() == "Play":
        bar.get_by_role("button").press("Enter")


def mean_rates_hz(walk: Path) -> dict[str, float]:
    """The rates of images by stream."""
    with AnyReader([walk]) as bag:
        images = [it for it in bag.connections if "/image_raw" in it.topic]
        return {it.topic.split("/")[2]: it.msgcount / length_ns(walk) * 1e9 for it in images}


def length_ns(walk: Path) -> int:
    """The time from the first message to the last, by another reader."""
    with AnyReader([walk]) as bag:
        return bag.end_time - bag.start_time - 1  # it counts an end after the last message


def middle_image_s(walk: Path, stream: str) -> float:
    """The time of a middle image: a busy machine records the first ones late."""
    with AnyReader([walk]) as bag:
        images = [it for it in bag.connections if f"/{stream}/image_raw" in it.topic]
        times_ns = [time_ns for _, time_ns, _ in bag.messages(images)]
        return (times_ns[len(times_ns) // 2] - bag.start_time) / 1e9


def pixels(page: Page) -> str:
    found: str = page.evaluate(_PIXELS)
    return found


def test_each_control_of_a_recording_is_reached_with_the_tab_key(page: Page) -> None:
    focused = f"{CONTROLS}.indexOf(document.activeElement)"
    count = page.evaluate(f"{CONTROLS}.length")
    reached = set[int]()
    for _ in range(count + 1):
        page.keyboard.press("Tab")
        reached.add(page.evaluate(focused))
    assert count > 8
    assert reached >= set(range(count))

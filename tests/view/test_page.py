"""The page in a real browser: what it shows, and how it answers mouse and keys."""

import json
import re
import zipfile
from typing import NoReturn

import cv2
import numpy as np
import pytest
import yaml
from playwright.sync_api import Browser, Locator, Page, expect

import bag_scene
from images import REPORTS, await_images, keep_screens
from lab import IMAGES, Lab, SentMessages, new_page
from ml2_tools.viewing import newest_image
from view_scene import ROWS, WORLD, serving
from waiting import await_true

CONTROLS = """() => [...document.querySelectorAll(
  "a[href], button, input, select, summary, [tabindex]"
)].filter((it) => it.checkVisibility())"""
COUNT = f"{CONTROLS}.length"
# The index of the control with the focus; -1 is none of them.
FOCUSED = f"{CONTROLS}.indexOf(document.activeElement)"
# The browser offers no way to hide a page without a screen.
HIDE = """() => {
  Object.defineProperty(document, "hidden", { get: () => true });
  document.dispatchEvent(new Event("visibilitychange"));
}"""


def tile(page: Page, stream: str) -> Locator:
    return page.locator(f"[data-stream={stream}]")


def show_eye(page: Page) -> None:
    page.get_by_role("button", name="Show this eye").click()


def test_images_of_each_stream_come_and_change(page: Page) -> None:
    show_eye(page)
    for stream in IMAGES:
        await_images(page, stream)
        rate, latency, stages = tile(page, stream).locator("figcaption p").all()[:3]
        expect(rate).to_have_text(re.compile(r"^[1-9]\d*\.\d of \d+ Hz, "))
        expect(latency).to_have_text(re.compile(r"^latency \d+\.\d ms, "))
        expect(stages).to_have_text(
            re.compile(r"^= headset \d+\.\d \+ link -?\d+\.\d \+ host \d+\.\d$")
        )
    REPORTS.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=REPORTS / "view.png")


def test_screens_live_and_paused_are_kept(browser: Browser, lab: Lab) -> None:
    page = new_page(browser)
    page.goto(lab.address)
    await_images(page, "world_left")
    await_images(page, "color")
    keep_screens(page, "live")
    bar = page.get_by_role("group", name="Time line")
    bar.get_by_role("button", name="Pause").click()
    bar.get_by_role("slider").press("PageDown")
    expect(bar.get_by_role("status")).to_contain_text("paused")
    keep_screens(page, "paused")
    page.context.close()


def test_a_snapshot_has_images_depth_points_cameras_and_poses(browser: Browser, lab: Lab) -> None:
    page = new_page(browser)
    page.goto(lab.address)
    await_images(page, "color", 1)
    await_images(page, "depth", 1)
    files: dict[str, bytes] = {}

    def has_points() -> bool:
        """False if poses or lenses came too late for its images, as on a busy machine."""
        with page.expect_download() as saved:
            page.get_by_role("button", name="Snapshot").click()
        with zipfile.ZipFile(saved.value.path()) as archive:
            files.clear()
            files.update({it: archive.read(it) for it in archive.namelist()})
        return "depth.ply" in files

    await_true(has_points)
    page.context.close()
    streams = ("color", "depth", "world_left")
    assert files.keys() == {
        *(f"{it}.{end}" for it in streams for end in ("png", "yaml")),
        "depth.ply",
        "poses.json",
    }
    color, depth = (
        cv2.imdecode(np.frombuffer(files[it], np.uint8), cv2.IMREAD_UNCHANGED)
        for it in ("color.png", "depth.png")
    )
    assert (color.shape, color.dtype.name) == ((480, 640, 3), "uint8")
    assert (depth.shape, depth.dtype.name) == ((480, 544), "uint16")
    # The room is some metres large, and depth.png is in mm.
    assert 500 < np.median(depth[depth > 0]) < 8000
    head, _, rows = files["depth.ply"].partition(b"end_header\n")
    (count,) = map(int, re.findall(rb"element vertex (\d+)", head))
    assert count == np.count_nonzero(depth)
    assert len(rows) == count * (15 if b"uchar red" in head else 12)
    camera = yaml.safe_load(files["color.yaml"])
    assert (camera["camera_name"], camera["image_width"]) == ("color", 640)
    poses = json.loads(files["poses.json"])
    assert np.array(poses["poses"]["head"]).shape == (4, 4)
    assert np.array(poses["images"]["depth"]["pose"]).shape == (4, 4)


def test_plots_draw_values(page: Page) -> None:
    outputs = page.locator("#plots output")
    expect(outputs.first).to_have_text(re.compile(r"x -?\d+\.\d+ y -?\d+\.\d+ z -?\d+\.\d+"))
    for number in range(outputs.count()):
        expect(outputs.nth(number)).not_to_have_text("no data")


def test_no_request_leaves_this_machine(browser: Browser, lab: Lab) -> None:
    page = new_page(browser)
    requested: list[str] = []
    page.context.on("request", lambda it: requested.append(it.url))
    page.on("websocket", lambda it: requested.append(it.url.replace("ws:", "http:")))
    page.goto(lab.address)
    await_images(page, "world_left")
    page.context.close()
    assert f"{lab.origin}/live" in requested
    assert len(requested) > 5
    assert [it for it in requested if not it.startswith(f"{lab.origin}/")] == []


def test_a_wrong_token_is_refused_in_words(browser: Browser, lab: Lab) -> None:
    page = new_page(browser)
    page.goto(f"{lab.origin}/#wrong")
    expect(page.locator("#notice")).to_contain_text("not valid any more")
    expect(page.locator("[data-stream]")).to_have_count(0)
    page.context.close()


def test_a_page_whose_server_fails_says_why_and_comes_again(
    browser: Browser, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> NoReturn:
        raise RuntimeError("nobody foresaw this")

    notice = (page := new_page(browser)).locator("#notice")
    with serving(ROWS) as served:
        page.goto(f"{served.url}/#{served.token}")
        expect(notice).to_be_hidden()
        with monkeypatch.context() as patched:
            patched.setattr(newest_image, "preview_of", broken)
            served.source.bring(WORLD, bag_scene.image(1))
            expect(notice).to_contain_text(re.compile("^Disconnected: .*nobody foresaw this"))
        expect(notice).to_be_hidden()
        served.source.bring(WORLD, bag_scene.image(2))
        await_images(page, "world_left", 1)
        page.context.close()


def test_a_page_without_one_of_its_files_says_so(browser: Browser) -> None:
    page = new_page(browser)
    page.route("**/plots.js", lambda it: it.abort())
    with serving(ROWS) as served:
        page.goto(f"{served.url}/#{served.token}")
        expect(page.locator("#notice")).to_contain_text("Reload it.")
        page.context.close()


def test_a_frozen_page_slows_no_other(browser: Browser, lab: Lab, page: Page) -> None:
    frozen = new_page(browser)
    frozen.goto(lab.address)
    await_images(frozen, "world_left", 1)
    browser_of_frozen = frozen.context.new_cdp_session(frozen)
    browser_of_frozen.send("Page.setWebLifecycleState", {"state": "frozen"})
    await_images(page, "world_left", 15)
    browser_of_frozen.send("Page.setWebLifecycleState", {"state": "active"})
    await_images(frozen, "world_left")
    frozen.context.close()


def test_a_hidden_page_asks_for_no_images(browser: Browser, lab: Lab) -> None:
    page = new_page(browser)
    sent = SentMessages(page)
    page.goto(lab.address)
    await_images(page, "world_left")
    with sent.expected(lambda it: it == {"show": []}):
        page.evaluate(HIDE)
    page.context.close()


def test_each_control_is_reached_with_the_tab_key(page: Page) -> None:
    expect(page.locator("[data-stream]")).to_have_count(len(IMAGES))
    page.get_by_text("Sensors and modes").press("Enter")
    expect(page.get_by_label("mode of picture center")).to_be_enabled()
    count, again = 0, page.evaluate(COUNT)
    reached = set[int]()
    # A message that gets lost meanwhile brings another control.
    while again != count:
        count = again
        reached.clear()
        # After the last control comes the page itself, and then the first one.
        for _ in range(count + 1):
            page.keyboard.press("Tab")
            reached.add(page.evaluate(FOCUSED))
        again = page.evaluate(COUNT)
    assert count > 40
    assert reached >= set(range(count))


def test_keys_hide_and_show_an_image(page: Page) -> None:
    await_images(page, "world_left")
    button = tile(page, "world_left").locator("figcaption button")
    button.focus()
    page.keyboard.press("Enter")
    expect(button).to_have_text("Show")
    page.keyboard.press("Space")
    expect(button).to_have_text("Hide")
    await_images(page, "world_left")

"""Changes on the page reach the simulated headset, and the page shows them."""

import re
import subprocess

import pytest
from playwright.sync_api import Locator, Page, expect
from rosbags.highlevel import AnyReader

from images import await_images, keep_screens
from lab import Lab
from ml2_receiver.configuration.config import load_config
from processes import RECEIVER
from waiting import await_true

_COLOR = "[data-stream=color]"
_REFUSED = "0 648x720@30"


@pytest.fixture(scope="module")
def page(page: Page) -> Page:
    """The page with the open list of sensors, and the values in force."""
    page.get_by_text("Sensors and modes").click()
    expect(row(page, "picture_center").get_by_role("checkbox")).to_be_enabled()
    return page


def row(page: Page, section: str) -> Locator:
    return page.locator(f"[data-section={section}]")


def test_a_sensor_is_switched_off_and_on(page: Page) -> None:
    world = page.locator("[data-stream=world_left]")
    expect(world).to_be_visible()
    switch = row(page, "world_left").get_by_role("checkbox")
    switch.uncheck()
    expect(world).to_have_count(0)
    expect(switch).not_to_be_checked()
    switch.check()
    expect(row(page, "world_left")).to_contain_text("running, 1016x1016@30 jpeg")
    await_images(page, "world_left")


def test_a_mode_and_a_format_reach_the_headset(page: Page) -> None:
    mode = page.get_by_label("mode of picture center")
    expect(mode).to_have_value("0 640x480@15")
    mode.select_option("0 1280x720@30")
    expect(row(page, "picture_center")).to_contain_text("running, 1280x720@30 jpeg")
    expect(page.locator(_COLOR)).to_contain_text("1280x720@30 jpeg")
    await_images(page, "color", width=1280)
    mode.select_option("0 640x480@15")
    page.get_by_label("format of depth center").select_option("DepthRaw")
    await_images(page, "infra")
    expect(page.locator("[data-stream=depth]")).to_have_count(0)
    page.get_by_label("format of depth center").select_option("depth16")
    await_images(page, "depth")


def test_a_jpeg_quality_reaches_the_headset(page: Page) -> None:
    quality = page.get_by_label("JPEG quality of world left")
    expect(quality).to_have_value("80")
    quality.fill("35")
    quality.press("Tab")
    expect(row(page, "world_left")).not_to_have_attribute("aria-busy", "true")
    expect(quality).to_have_value("35")
    expect(row(page, "world_left").get_by_role("status")).to_be_empty()
    page.get_by_label("format of world left").select_option("Grayscale")
    expect(quality).to_be_hidden()
    await_images(page, "world_left")
    page.get_by_label("format of world left").select_option("jpeg")
    expect(quality).to_have_value("35")
    await_images(page, "world_left")
    quality.fill("101")
    quality.press("Tab")
    assert quality.evaluate("(it) => it.matches(':invalid')")


def test_the_bound_of_the_link_reaches_the_receiver(page: Page) -> None:
    link = page.get_by_label("link", exact=True)
    expect(link).to_have_value("auto")
    link.fill("90")
    link.press("Tab")
    expect(row(page, "general")).not_to_have_attribute("aria-busy", "true")
    expect(link).to_have_value("90")
    for wrong in ("much", "0", "-5", "1e9999"):
        link.fill(wrong)
        link.press("Tab")
        assert link.evaluate("(it) => it.matches(':invalid')"), wrong
    link.fill("auto")
    link.press("Tab")
    expect(row(page, "general")).not_to_have_attribute("aria-busy", "true")


def test_a_refused_change_is_explained_beside_the_control(page: Page) -> None:
    color = row(page, "picture_center")
    mode = page.get_by_label("mode of picture center")
    expect(mode).to_have_value("0 640x480@15")
    # The page offers no mode that is refused.
    mode.evaluate("(it, value) => it.add(new Option('refused', value))", _REFUSED)
    mode.select_option(_REFUSED)
    expect(color.get_by_role("status")).to_contain_text("expected")
    expect(color.get_by_role("status")).to_contain_text("648")
    expect(mode).to_have_value("0 640x480@15")


def test_what_was_changed_on_this_page_is_saved_and_nothing_else(page: Page, lab: Lab) -> None:
    toolbar, save = page.get_by_role("toolbar"), page.get_by_role("button", name="Save changes")
    row(page, "pressure").get_by_role("checkbox").uncheck()
    expect(row(page, "pressure")).not_to_have_attribute("aria-busy", "true")
    set_layout(lab, "rig")
    save.click()
    expect(toolbar).to_contain_text("Save changes: written to ")
    saved = load_config(lab.folder / "config.yaml").values
    assert (saved["pressure.enabled"], saved["tf.layout"]) == (False, "flat")
    save.click()
    expect(toolbar).to_contain_text("not as in the file are tf.layout")
    set_layout(lab, "flat")


def set_layout(lab: Lab, layout: str) -> None:
    command = [str(RECEIVER), "set", f"tf.layout={layout}"]
    subprocess.run(command, env=lab.environment, check=True, stdout=subprocess.DEVNULL)


def test_streams_stop_and_start(page: Page) -> None:
    page.get_by_role("button", name="Stop streams").click()
    expect(page.get_by_role("toolbar")).to_contain_text("Stop streams: streams are stopped")
    expect(row(page, "world_left")).to_contain_text("paused")
    expect(page.get_by_role("button", name="Stop streams")).to_have_count(0)
    page.get_by_role("button", name="Start streams").click()
    expect(row(page, "world_left")).to_contain_text("running")
    await_images(page, "world_left")


def test_a_recording_of_the_page_is_a_bag(page: Page, lab: Lab) -> None:
    toolbar = page.get_by_role("toolbar")
    record = page.locator("#record")
    record.click()
    expect(toolbar).to_contain_text("Record: recording into ")
    expect(page.locator("#facts")).to_contain_text(re.compile(r"recordingrecording, [1-9]\d* s, "))
    expect(record).to_have_text(re.compile(r"^Stop recording \d:\d\d$"))
    expect(record).to_have_css("background-color", "rgb(179, 20, 31)")
    keep_screens(page, "recording")
    record.click()
    expect(toolbar).to_contain_text("Stop recording: recorded into ")
    (folder,) = lab.folder.glob("ml2_*")
    with AnyReader([folder]) as bag:
        counts = {it.topic: it.msgcount for it in bag.connections}
    assert counts["/magic_leap2/world_left/image_raw/compressed"] > 0
    expect(record).to_have_text("Record")
    expect(record).to_have_attribute("aria-pressed", "false")


def test_products_are_made_until_they_are_switched_off(page: Page, lab: Lab) -> None:
    button, topic = page.locator("#products"), "/magic_leap2/depth/points"
    with lab.node("looks_for_products") as node:
        button.click()
        expect(button).to_have_text("Stop products")
        await_true(lambda: node.count_publishers(topic) == 1)
        button.click()
        expect(button).to_have_text("Make products")
        await_true(lambda: node.count_publishers(topic) == 0)


def test_the_link_is_tested(page: Page) -> None:
    page.get_by_role("button", name="Test the link").click()
    expect(page.locator("#facts")).to_contain_text(re.compile(r"link.*Mbit/s"))

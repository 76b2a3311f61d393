"""An image in full size, with the value of a pixel."""

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from images import REPORTS, await_images


@pytest.fixture
def dialog(page: Page) -> Locator:
    """The depth image in full size."""
    await_images(page, "depth", 1)
    page.locator("[data-stream=depth] canvas").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_be_visible()
    return dialog


def test_a_click_enlarges_and_escape_returns(page: Page, dialog: Locator) -> None:
    canvas = dialog.locator("canvas")
    page.wait_for_function("() => document.querySelector('#enlarged canvas').width === 544")
    box = canvas.bounding_box()
    assert box is not None
    assert min(box["width"] / 544, box["height"] / 480) > 1.2
    canvas.hover()
    # The middle of 544x480 pixels, to the pixel that half a screen pixel makes unsure.
    expect(dialog.get_by_role("status")).to_have_text(
        re.compile(r"^27[12], (239|240): (\d\.\d{3} m|invalid)$")
    )
    # Beside the image is no pixel.
    canvas.hover(position={"x": 2, "y": box["height"] / 2})
    expect(dialog.get_by_role("status")).to_have_text("")
    canvas.hover(position={"x": box["width"] / 2, "y": box["height"] * 0.9})
    expect(dialog.get_by_role("status")).to_have_text(re.compile(r"^27\d, 43\d: [1-4]\.\d{3} m$"))
    page.screenshot(path=REPORTS / "view_enlarged.png")
    page.keyboard.press("Escape")
    expect(dialog).to_be_hidden()
    await_images(page, "depth")


def test_keys_enlarge_an_image_and_choose_a_pixel(page: Page) -> None:
    tile = page.locator("[data-stream=color] canvas")
    await_images(page, "color", 1)
    tile.focus()
    page.keyboard.press("Enter")
    dialog = page.get_by_role("dialog")
    page.wait_for_function("() => document.querySelector('#enlarged canvas').width === 640")
    page.keyboard.press("ArrowRight")
    words = re.compile(r"^321, 240: red \d+, green \d+, blue \d+$")
    expect(dialog.get_by_role("status")).to_have_text(words)
    page.keyboard.press("Shift+ArrowUp")
    expect(dialog.get_by_role("status")).to_have_text(re.compile(r"^321, 230: red "))
    dialog.get_by_role("button", name="Close").press("Enter")
    expect(dialog).to_be_hidden()
    expect(tile).to_be_focused()

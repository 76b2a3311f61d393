"""A headset is paired with the QR code that the page shows."""

import re

import cv2
import numpy as np
from playwright.sync_api import Page, expect

from images import REPORTS

_URI = re.compile(r"ml2s://\S+\?fp=[0-9a-f]{64}&token=[0-9a-f]{32}")


def test_the_code_on_the_screen_is_that_of_the_uri(page: Page) -> None:
    page.get_by_role("button", name="Pair a headset").press("Enter")
    dialog = page.get_by_role("dialog", name="Pair a headset")
    expect(dialog.get_by_role("status")).to_have_text(
        re.compile(r"^waiting for the headset, [45]:\d\d left$")
    )
    uri = dialog.locator(".uri")
    expect(uri).to_have_text(_URI)
    screen = cv2.imdecode(np.frombuffer(page.screenshot(), np.uint8), cv2.IMREAD_GRAYSCALE)
    found, _, _ = cv2.QRCodeDetectorAruco().detectAndDecode(screen)
    assert found == uri.text_content()
    # The screenshot that is kept shows no secret.
    uri.evaluate("(it) => it.textContent = 'ml2s://…'")
    page.screenshot(path=REPORTS / "view_pairing.png", mask=[dialog.locator("canvas")])
    page.keyboard.press("Escape")
    expect(dialog).to_be_hidden()
    expect(page.locator("body")).not_to_contain_text(_URI)

"""A page of `ml2-receiver view` in Chromium."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from lab import LIMIT_MS, Lab, new_page, running_lab


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Puts the tests without a lab first, since it fills a processor from its first test on.

    Of a module, those that do not share a page come first, since that draws from its first test on.
    """

    def order(item: pytest.Item) -> tuple[bool, Path, bool]:
        fixtures = getattr(item, "fixturenames", ())
        return "lab" in fixtures, item.path, "page" in fixtures

    items.sort(key=order)


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    with running_lab(tmp_path_factory.mktemp("lab")) as lab:
        yield lab


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    chromium = shutil.which("chromium")
    assert chromium is not None, "`make test-view` installs chromium"
    expect.set_options(timeout=LIMIT_MS)
    with sync_playwright() as playwright:
        # Without a graphics card, reading an accelerated canvas is slow.
        options = ["--disable-accelerated-2d-canvas"]
        browser = playwright.chromium.launch(executable_path=chromium, args=options)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def page(browser: Browser, lab: Lab) -> Iterator[Page]:
    """The page, which shows the state of a connected headset."""
    page = new_page(browser, "dark")
    page.goto(lab.address)
    expect(page.locator("#facts")).to_contain_text("connected")
    yield page
    page.context.close()

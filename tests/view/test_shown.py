"""What the page makes of messages that a test has chosen."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from lab import new_page
from view_scene import IMAGE, ROWS, WORLD, serving
from view_scene import Page as Served

_GYRO = "/magic_leap2/gyro_left/imu"


@pytest.fixture
def served() -> Iterator[Served]:
    with serving(ROWS) as served:
        yield served


@pytest.fixture
def page(browser: Browser, served: Served) -> Iterator[Page]:
    page = new_page(browser, "light")
    page.goto(f"{served.url}/#{served.token}")
    expect(page.locator("#facts")).to_contain_text("head")
    yield page
    page.context.close()


def test_losses_are_those_of_the_last_10_s_until_all_are_asked_for(
    page: Page, served: Served
) -> None:
    def report(at_s: float, world: int, gyro: int) -> None:
        served.source.clock_s = at_s
        counts = {"unpublished": "0", "message": "running"}
        served.source.report(
            {
                **ROWS,
                WORLD: {
                    "stream": "world_left",
                    "type": IMAGE,
                    "gaps": str(world),
                    **counts,
                },
                _GYRO: {"type": "sensor_msgs/msg/Imu", "gaps": str(gyro), **counts},
            }
        )

    losses = page.locator("#losses")
    rate = page.locator("[data-stream=world_left] figcaption p").first
    # What was lost before the page saw a topic is not recent.
    report(1, 4, 300)
    expect(losses.locator("summary")).to_have_text("lost in the last 10 s: 4 messages of 1 topic")
    report(11, 6, 301)
    expect(losses.locator("summary")).to_have_text("lost in the last 10 s: 3 messages of 2 topics")
    expect(rate).to_contain_text("2 lost")
    expect(losses.get_by_role("row")).to_have_count(0)
    losses.locator("summary").press("Enter")
    expect(losses.get_by_role("row")).to_have_text(
        [
            "topiclost in 10 ssince the start",
            f"{WORLD}26",
            f"{_GYRO}1301",
        ]
    )
    report(22, 6, 301)
    expect(losses.locator("summary")).to_have_text("lost in the last 10 s: nothing")
    expect(rate).to_contain_text("nothing lost")
    expect(losses.get_by_role("row").nth(1)).to_have_text(f"{_GYRO}0301")


def test_the_stages_of_latency_add_up_and_the_rate_is_not_above_what_is_asked(
    page: Page, served: Served
) -> None:
    stages = {
        "capture_to_sent": "10.26",
        "sent_to_received": "1.26",
        "received_to_published": "0.26",
    }
    row = {
        **ROWS[WORLD],
        "rate_hz": "34.0",
        "expected_hz": "30",
        "latency_p50_ms": "99.9",
        **{f"window.{name}_ms": ms for name, ms in stages.items()},
    }
    served.source.report({**ROWS, WORLD: row})
    rate, latency, parts = page.locator("[data-stream=world_left] figcaption p").all()[:3]
    expect(parts).to_have_text("= headset 10.3 + link 1.3 + host 0.3")
    expect(latency).to_have_text(re.compile("^latency 11.9 ms, p99 "))
    expect(rate).to_contain_text("30.0 of 30 Hz")


def test_what_cannot_be_done_is_disabled_and_says_why(page: Page, served: Served) -> None:
    bar = page.get_by_role("toolbar")
    stop, link = (bar.get_by_role("button", name=it) for it in ("Stop streams", "Test the link"))
    expect(stop).to_be_enabled()
    served.source.report({"session": {"state": "waiting"}})
    for button in (stop, link):
        expect(button).to_be_disabled()
        expect(button).to_have_attribute("title", "no headset is connected")
    link.press("Enter")
    expect(bar.get_by_role("status")).to_have_text("Test the link: no headset is connected")
    expect(bar.get_by_role("button", name="Record")).to_be_enabled()
    served.view.fail("nobody reports")
    expect(bar.get_by_role("button", name="Record")).to_have_attribute("title", "nobody reports")
    served.source.report(ROWS)
    expect(link).to_be_enabled()


def test_one_button_records_and_shows_for_how_long(page: Page, served: Served) -> None:
    record = page.locator("#record")
    expect(record).to_have_text("Record")
    recording = {"state": "recording", "duration_s": "75.9"}
    served.source.report({**ROWS, "recording": recording})
    expect(record).to_have_text("Stop recording 1:15")
    expect(record).to_have_attribute("aria-pressed", "true")
    served.source.report({**ROWS, "recording": {**recording, "state": "ended"}})
    expect(record).to_have_text("Record")


def test_one_button_starts_and_stops_the_streams(page: Page, served: Served) -> None:
    button = page.locator("#streaming")
    expect(button).to_have_text("Stop streams")
    paused = {"state.world_left": "paused", "state.depth": "paused"}
    served.source.report({**ROWS, "session": {**ROWS["session"], **paused}})
    expect(button).to_have_text("Start streams")

"""The page shows messages that a test has chosen."""

import re
from collections.abc import Iterator

import cv2
import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, expect
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Illuminance, Joy
from std_msgs.msg import String

import bag_scene
from lab import new_page
from view_scene import COUNTS, IMAGE, ROWS, WORLD, serving
from view_scene import Page as Served
from waiting import await_true

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
    # Messages lost before the page saw their topic are not recent losses.
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


def test_what_the_app_subscribes_to_is_listed_until_nothing_is(page: Page, served: Served) -> None:
    shown = page.locator("#subscriptions")
    expect(shown).to_be_hidden()
    counts = {"sent": "9", "dropped.superseded": "4", "missed": "1", "message": "lost messages: 1"}
    row = {"message_type": "std_msgs/msg/<b>", **counts}
    served.source.report(ROWS | {"subscription /said": row})
    expect(shown.locator("summary")).to_have_text("the app subscribes to 1 topic of ROS")
    shown.locator("summary").press("Enter")
    expect(shown.get_by_role("row").nth(1)).to_have_text("/saidstd_msgs/msg/<b>941")
    served.source.report(ROWS)
    expect(shown).to_be_hidden()


def test_services_that_the_app_calls_and_offers_are_listed(page: Page, served: Served) -> None:
    shown = page.locator("#calls")
    expect(shown).to_be_hidden()
    row = {"service_type": "T", "requests": "9", "responses": "4", "failures": "1"}
    served.source.report(ROWS | {"client /pause": row, "service /custom/on": row})
    expect(shown.locator("summary")).to_have_text("the app calls or offers 2 services")
    shown.locator("summary").press("Enter")
    expect(shown.get_by_role("row").nth(1)).to_have_text("/pauseROST941")
    expect(shown.get_by_role("row").nth(2)).to_have_text("/custom/onthe appT941")


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


def test_any_numeric_field_of_any_topic_is_plotted(page: Page, served: Served) -> None:
    joy = "/magic_leap2/controller/joy"
    served.source.report({**ROWS, joy: {"type": "sensor_msgs/msg/Joy", **COUNTS}})
    page.get_by_label("topic to plot").select_option(joy)
    page.get_by_label("field to plot").select_option("axes[1]")
    page.get_by_role("button", name="Plot", exact=True).click()
    plot = page.locator(".plot", has_text=f"{joy} axes[1]")
    for axes, shown in ((0.25, 0.75), "0.75"), ((0.5,), "0.75"), ((0.5, -2.5), "-2.5"):
        served.source.bring(joy, serialize_message(Joy(axes=axes)))
        served.source.clock_s += 1
        expect(plot.get_by_role("status")).to_have_text(re.compile(f"^{shown}"))
    plot.get_by_role("button").press("Enter")
    expect(plot).to_have_count(0)
    await_true(lambda: not [it for it in served.source.subscriptions if it.topic == joy])


def test_lost_samples_are_gaps_of_a_plot(page: Page) -> None:
    """1, 2 and 3 s have samples at 10 Hz; the next is one alone, and then come others."""
    times = [1.0, 1.1, 1.2, 1.3, 2.0, 3.0, 3.1, 3.2, 3.3]
    lines = page.evaluate(
        """async (values) => {
          const { gapOf, linesOf } = await import("/plot.js");
          return linesOf(values, 0, gapOf(values)).map((it) => it.map(([timeS]) => timeS));
        }""",
        [[it, [it]] for it in times],
    )
    assert lines == [times[:4], times[4:5], times[5:]]


def test_a_cursor_shows_the_values_of_its_time(page: Page, served: Served) -> None:
    light = "/magic_leap2/light_sensor"
    row = {"stream": "light_sensor", "type": "sensor_msgs/msg/Illuminance", **COUNTS}
    served.source.report({**ROWS, light: row})
    for at_s in range(100, 131):
        served.source.clock_s = float(at_s)
        served.source.bring(light, serialize_message(Illuminance(illuminance=float(at_s))))
    plot = page.locator(".plot", has_text="light")
    expect(plot.get_by_role("status")).to_have_text("130.0")
    expect(page.locator("#plots .axis")).to_contain_text("30 s ago")
    plots = page.locator("#plots .list")
    plots.focus()
    for _ in range(20):
        plots.press("ArrowLeft")
    expect(page.locator("#plots .axis")).to_contain_text("cursor: 10.0 s ago")
    expect(plot.get_by_role("status")).not_to_have_text("130.0")
    plots.press("Escape")
    expect(plot.get_by_role("status")).to_have_text("130.0")
    box = plot.locator("canvas").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 44 + (box["width"] - 44) / 2, box["y"] + 20)
    expect(page.locator("#plots .axis")).to_contain_text(re.compile(r"cursor: 1[45]\.\d s ago"))


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


def test_on_a_narrow_screen_the_first_camera_is_in_the_first_screen(
    page: Page, served: Served
) -> None:
    words = "a sentence of some length, as the receiver says it in /diagnostics"
    rows = {name: {"message": words} for name in ("security", "clock", "link", "a", "b", "c")}
    served.source.report({**ROWS, **rows, WORLD: {**ROWS[WORLD], "gaps": "7"}})
    page.set_viewport_size({"width": 390, "height": 844})
    expect(page.locator("#losses")).to_be_visible()
    box = page.locator("[data-stream=world_left] canvas").bounding_box()
    assert box is not None
    assert box["y"] + box["height"] <= 844
    scene = page.locator("#scene").bounding_box()
    assert scene is not None
    assert scene["y"] > box["y"]
    for element in ("document.documentElement", "document.querySelector('#streams')"):
        assert page.evaluate(f"{element}.scrollWidth") <= 390


def test_the_3d_view_follows_the_theme(page: Page) -> None:
    def corner() -> int:
        shot = page.locator("#scene canvas").screenshot()
        return int(cv2.imdecode(np.frombuffer(shot, np.uint8), cv2.IMREAD_GRAYSCALE)[5, 5])

    await_true(lambda: corner() > 200)
    page.emulate_media(color_scheme="dark")
    await_true(lambda: corner() < 50)


def test_a_paused_page_looks_back_and_plays_until_it_is_live_again(
    page: Page, served: Served
) -> None:
    pixels = "() => document.querySelector('[data-stream=world_left] canvas').toDataURL()"
    differs = f"(them) => !them.includes(({pixels})())"
    is_first = f"(first) => ({pixels})() === first"
    seen = [page.evaluate(pixels)]
    for number in (1, 2):
        served.source.bring(WORLD, bag_scene.image(number))
        page.wait_for_function(differs, arg=seen)
        seen.append(page.evaluate(pixels))
        # The page keeps at most 5 images per second.
        page.wait_for_function("(then) => performance.now() > then + 250", arg=now_ms(page))
    bar = page.get_by_role("group", name="Time line")
    button, slider = bar.get_by_role("button"), bar.get_by_role("slider")
    expect(bar.get_by_role("status")).to_have_text("live")
    button.press("Enter")
    expect(bar.get_by_role("status")).to_have_text(re.compile(r"^paused, 0\.0 s before · \d\d:"))
    await_true(lambda: WORLD not in [it.topic for it in served.source.subscriptions])
    await_true(lambda: step_back(slider) and page.evaluate(is_first, seen[1]))
    expect(page.locator("#plots .axis")).to_contain_text(re.compile(r"cursor: \d.*pause"))
    page.locator("[data-stream=world_left] canvas").click()
    still = page.get_by_role("dialog", name="Image in full size")
    expect(still).to_contain_text("paused")
    page.keyboard.press("Escape")
    button.press("Enter")
    page.wait_for_function(is_first, arg=seen[2])
    expect(bar.get_by_role("status")).to_have_text("live")
    served.source.bring(WORLD, bag_scene.image(3))
    page.wait_for_function(differs, arg=seen)


def test_what_a_page_keeps_to_look_back_is_thinned_and_bounded(page: Page) -> None:
    thinned, bounded = page.evaluate(
        """async () => {
          const { History } = await import("/history.js");
          const history = new History({ image: () => {} }, () => {});
          history.reset(true);
          for (let i = 0; i < 100; i++) history.image("one", { size: 1e6 }, 0);
          const thinned = history.bytes;
          for (let i = 0; i < 200; i++) history.image(`many ${i}`, { size: 1e6 }, 0);
          return [thinned, history.bytes];
        }"""
    )
    # All of a name at once are one, unless the page stood still meanwhile.
    assert thinned < 50e6
    assert bounded == 64e6


def now_ms(page: Page) -> float:
    return float(page.evaluate("() => performance.now()"))


def step_back(slider: Locator) -> bool:
    slider.press("ArrowLeft")
    return True


def test_the_distance_between_two_places_is_measured(page: Page) -> None:
    words = page.evaluate(
        """async () => {
          const { Measure } = await import("/measure.js");
          const { PerspectiveCamera, Scene, Points } = await import("/three.min.js");
          const figure = document.getElementById("scene");
          const camera = new PerspectiveCamera();
          const measure = new Measure(figure, new Scene(), camera, new Points(), () => {});
          figure.querySelector("[data-measure]").click();
          const output = figure.querySelector("output");
          const words = [output.textContent];
          for (const place of [[1, 2, 3], [1, 5, 7], [0, 0, 0]]) {
            measure.take(place);
            words.push(output.textContent);
          }
          return words;
        }"""
    )
    assert words == ["choose a point", "choose another point", "5.000 m", "choose another point"]


def test_the_log_shows_its_newest_line_and_on_demand_all(page: Page, served: Served) -> None:
    log = page.locator("#log")
    for text in ("streams are started", "WARNING: <b>too hot</b>"):
        served.source.bring("/magic_leap2/log", serialize_message(String(data=text)))
    summary = log.locator("summary")
    expect(summary).to_have_text(re.compile(r"^log: [\d:.]+ WARNING: <b>too hot</b>$"))
    expect(log.get_by_role("listitem")).to_have_count(0)
    summary.press("Enter")
    expect(log.get_by_role("listitem")).to_contain_text(["too hot", "streams are started"])

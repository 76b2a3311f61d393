"""The 3D view of the page."""

import itertools
import re

import pytest
from geometry_msgs.msg import TransformStamped
from playwright.sync_api import Browser, Locator, Page, expect
from rclpy.qos import DurabilityPolicy, QoSProfile
from tf2_msgs.msg import TFMessage

from lab import Lab, SentMessages, new_page

_SHOWN = ("head", "color", "depth", "world left", "hand left", "hand right", "gaze")


@pytest.fixture
def scene(page: Page) -> Locator:
    """The 3D view, once it shows everything."""
    scene = page.locator("#scene")
    for name in _SHOWN:
        expect(scene.get_by_role("list")).to_contain_text(name)
    return scene


def await_changes(scene: Locator) -> None:
    """Waits for two different pictures; the test's time limit ends an endless wait."""
    pictures = set[bytes]()
    while len(pictures) < 2:
        pictures.add(scene.locator("canvas").screenshot())


def test_it_moves_in_each_view(scene: Locator) -> None:
    for name in ("Follow", "Orbit", "Top"):
        button = scene.get_by_role("button", name=name)
        button.press("Enter")
        expect(button).to_have_attribute("aria-pressed", "true")
        await_changes(scene)


def test_dragging_and_arrow_keys_leave_the_head(page: Page, scene: Locator) -> None:
    follow, orbit = (scene.get_by_role("button", name=it) for it in ("Follow", "Orbit"))
    follow.click()
    scene.locator("canvas").press("Shift+ArrowLeft")
    expect(orbit).to_have_attribute("aria-pressed", "true")
    follow.click()
    expect(orbit).to_have_attribute("aria-pressed", "false")
    scene.locator("canvas").drag_to(scene.locator(".legend"))
    expect(orbit).to_have_attribute("aria-pressed", "true")


def test_a_frame_that_another_program_attaches_to_the_world_is_shown(
    scene: Locator, lab: Lab
) -> None:
    robot = TransformStamped()
    robot.header.frame_id, robot.child_frame_id = "magicleap_world", "robot_base_link"
    with lab.node("robot") as node:
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        publisher = node.create_publisher(TFMessage, "/tf_static", latched)
        publisher.publish(TFMessage(transforms=[robot]))
        expect(scene.get_by_role("list")).to_contain_text("robot_base_link")


def test_two_clicks_on_points_measure_between_them(scene: Locator) -> None:
    # From behind the head, what it sees fills the lower half; from above, a wall is a line.
    scene.get_by_role("button", name="Orbit").click()
    scene.get_by_role("button", name="Measure").click()
    said, canvas = scene.get_by_role("status"), scene.locator("canvas")
    box = canvas.bounding_box()
    assert box is not None
    found = set[str]()
    for row, column in itertools.product(range(27, 9, -2), range(5, 28, 2)):
        at = {"x": box["width"] * column / 32, "y": box["height"] * row / 32}
        canvas.click(position=at)  # type: ignore[arg-type]
        found.add(said.text_content() or "")
        if any(re.fullmatch(r"\d+\.\d{3} m", it) for it in found):
            break
    assert "choose another point" in found
    assert any(re.fullmatch(r"\d+\.\d{3} m", it) for it in found), found
    canvas.press("Escape")
    expect(said).to_be_empty()


def test_a_click_beside_all_points_says_so(scene: Locator) -> None:
    scene.get_by_role("button", name="Orbit").click()
    scene.get_by_role("button", name="Measure").click()
    said, canvas = scene.get_by_role("status"), scene.locator("canvas")
    canvas.click(position={"x": 5, "y": 5})
    expect(said).to_have_text("no point there")
    canvas.press("Escape")


def test_the_tree_has_the_frames_by_name(scene: Locator) -> None:
    tree = scene.locator("details")
    tree.locator("summary").click()
    root = tree.get_by_role("treeitem").filter(has_text=re.compile("^magicleap_world"))
    expect(root.get_by_role("treeitem").filter(has_text=re.compile("^head_frame"))).to_be_visible()
    tree.locator("summary").click()


def test_frusta_show_images_until_they_are_switched_off(page: Page, scene: Locator) -> None:
    button = scene.get_by_role("button", name="Images")
    button.click()
    expect(button).to_have_attribute("aria-pressed", "false")
    button.click()
    expect(button).to_have_attribute("aria-pressed", "true")


def test_points_come_while_the_image_of_depth_is_shown(browser: Browser, lab: Lab) -> None:
    page = new_page(browser)
    with SentMessages(page).expected(lambda it: it == {"seen": "cloud"}):
        page.goto(lab.address)
        expect(page.locator("[data-stream=depth]")).to_be_visible()
    page.context.close()


def test_a_hidden_view_asks_for_nothing(browser: Browser, lab: Lab) -> None:
    page = new_page(browser)
    sent = SentMessages(page)
    page.goto(lab.address)
    scene = page.locator("#scene")
    expect(scene.get_by_role("list")).to_contain_text("head")
    with sent.expected(lambda it: "scene" not in it.get("show", ["scene"])):
        scene.get_by_role("button", name="Hide").click()
    with sent.expected(lambda it: "scene" in it.get("show", [])):
        scene.get_by_role("button", name="Show").click()
    page.context.close()

"""Looks at the images that a page draws."""

from pathlib import Path
from typing import Literal

from playwright.sync_api import Page

REPORTS = Path(__file__).resolve().parents[2] / "build" / "reports"
_SCHEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")
# Counts the different images on a canvas, of which a flat one is none. The page asks for images
# only while they can be seen.
_HAVE_COME = """([stream, wanted, width]) => {
  const canvas = document.querySelector(`[data-stream=${stream}] canvas`);
  if (!canvas) return false;
  canvas.scrollIntoView({ block: "nearest" });
  if (width ? canvas.width !== width : canvas.width < 16) return false;
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const pixels = Uint8Array.from({ length: data.length / 388 }, (_, i) => data[i * 388]);
  if (new Set(pixels).size < 20) return false;
  const seen = ((window.seenImages ??= {})[stream] ??= new Set());
  seen.add(pixels.join());
  return seen.size >= wanted;
}"""


def keep_screens(page: Page, name: str) -> None:
    """Saves the page as laptops and phones show it, light and dark; nothing is wider than it."""
    before = page.viewport_size
    assert before is not None
    REPORTS.mkdir(parents=True, exist_ok=True)
    for width, height in ((1366, 768), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        for scheme in _SCHEMES:
            page.emulate_media(color_scheme=scheme)
            page.evaluate("() => new Promise((done) => setTimeout(done, 300))")
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            page.screenshot(path=REPORTS / f"view_{name}_{width}_{scheme}.png")
    page.set_viewport_size(before)


def await_images(page: Page, stream: str, count: int = 3, width: int | None = None) -> None:
    """Waits until the page has drawn `count` more images that differ, each of many levels.

    Args:
        width: of the images, in pixels; None is any.
    """
    page.evaluate("(stream) => { (window.seenImages ??= {})[stream] = new Set(); }", stream)
    page.wait_for_function(_HAVE_COME, arg=[stream, count, width], polling=50)

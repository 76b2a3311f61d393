"""Looks at the images that a page draws."""

from __future__ import annotations

from playwright.sync_api import Page

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


def await_images(page: Page, stream: str, count: int = 3, width: int | None = None) -> None:
    """Waits until the page has drawn `count` more images that differ, each of many levels.

    Args:
        width: of the images, in pixels; None is any.
    """
    page.evaluate("(stream) => { (window.seenImages ??= {})[stream] = new Set(); }", stream)
    page.wait_for_function(_HAVE_COME, arg=[stream, count, width], polling=50)

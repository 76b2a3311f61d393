"""Images of a headset as JPEG previews for browsers, and in full size."""

from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from ml2_tools.viewing.preview import Preview, full_of, preview_of


def image(pixels: NDArray[Any], encoding: str) -> Any:
    height, width = pixels.shape
    step = width * pixels.itemsize
    data = pixels.tobytes()
    return SimpleNamespace(
        height=height, width=width, encoding=encoding, is_bigendian=0, step=step, data=data
    )


def jpeg(pixels: NDArray[Any], quality: int) -> Any:
    data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
    return SimpleNamespace(format="rgb8; jpeg compressed bgr8", data=data)


def decoded(preview: Preview) -> NDArray[Any]:
    return np.asarray(cv2.imdecode(np.frombuffer(preview.jpeg, np.uint8), cv2.IMREAD_UNCHANGED))


def test_the_longer_side_of_a_grey_preview_is_640_pixels() -> None:
    ramp = np.tile(np.linspace(0, 255, 1280, dtype=np.uint8), (960, 1))
    found = decoded(preview_of(image(ramp, "mono8"), is_distance=False))
    assert found.shape == (480, 640)
    assert found[200, [5, 635]] == pytest.approx([2, 253], abs=4)


def test_a_small_jpeg_stays_as_it_is() -> None:
    message = jpeg(np.full((1080, 1920, 3), 90, np.uint8), 80)
    assert preview_of(message, is_distance=False) == Preview(message.data, 0)


def test_a_large_jpeg_is_made_smaller_but_stays_as_it_is_in_full_size() -> None:
    noise = np.random.default_rng(1).integers(0, 256, (1080, 1920, 3), np.uint8)
    message = jpeg(noise, 95)
    found = preview_of(message, is_distance=False)
    assert decoded(found).shape == (360, 640, 3)
    assert full_of(message, is_distance=False) == Preview(message.data, 0)


def test_other_images_are_encoded_in_full_size() -> None:
    ramp = np.tile(np.linspace(0, 255, 1280, dtype=np.uint8), (960, 1))
    found = decoded(full_of(image(ramp, "mono8"), is_distance=False))
    assert np.abs(found.astype(int) - ramp).max() <= 3
    metres = image(np.full((960, 1280), 0.9, np.float32), "32FC1")
    depth = full_of(metres, is_distance=True)
    assert (decoded(depth).shape, depth.far_m) == ((960, 1280, 3), 1)


@pytest.mark.parametrize(
    ("metres", "far_m"), [(0.1, 0.5), (0.9, 1), (1.2, 2), (2.4, 5), (5.1, 10), (43, 50)]
)
def test_the_scale_of_distances_ends_at_a_step(metres: float, far_m: float) -> None:
    flat = image(np.full((4, 4), metres, np.float32), "32FC1")
    assert preview_of(flat, is_distance=True).far_m == pytest.approx(far_m)


def test_near_is_blue_far_is_red_and_invalid_is_black() -> None:
    metres = np.repeat(np.array([[0.5, 3.9, np.nan]], np.float32), 32, axis=1).repeat(16, axis=0)
    found = decoded(preview_of(image(metres, "32FC1"), is_distance=True))
    near, far, invalid = (found[8, it].astype(int) for it in (16, 48, 80))
    assert near[0] > 150 > near[2]
    assert far[2] > 150 > far[0]
    assert invalid == pytest.approx([0, 0, 0], abs=8)


def test_an_image_without_any_distance_is_black() -> None:
    nothing = image(np.full((16, 16), np.nan, np.float32), "32FC1")
    assert decoded(preview_of(nothing, is_distance=True)).max() < 8


@pytest.mark.parametrize(
    "message",
    [
        SimpleNamespace(format="jpeg", data=b"\xff\xd8 no JPEG"),
        SimpleNamespace(format="h264", data=b"0000"),
        SimpleNamespace(format="jpeg", data=jpeg(np.zeros((9, 9, 3), np.uint8), 80).data[:30]),
    ],
)
def test_a_broken_image_is_refused(message: Any) -> None:
    with pytest.raises(ValueError, match="expected"):
        preview_of(message, is_distance=False)

"""OpenCV reads the JPEGs of the library that ships; another encoder makes the same of depth."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from compressed_images import compressed_depth
from native_encoders import DEPTH_RVL, GREY_JPEG, EncoderError, encode

SIZES = [(8, 8), (1, 1), (17, 5), (400, 400), (1016, 1016), (4096, 3072)]


def scene(width: int, height: int) -> NDArray[np.uint8]:
    """Returns soft shapes with the noise of a camera."""
    random = np.random.default_rng(width)
    shapes = cv2.GaussianBlur(random.integers(0, 256, (height, width), np.uint8), (0, 0), 4)
    grey = 128 + 4 * (np.array(shapes, np.float64) - 128) + random.normal(0, 2, (height, width))
    return grey.clip(0, 255).astype(np.uint8)


def decoded(jpeg: bytes) -> NDArray[Any]:
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_UNCHANGED)
    assert image is not None
    return image


@pytest.mark.parametrize("size", SIZES)
def test_opencv_reads_one_grey_channel_as_good_as_its_own(size: tuple[int, int]) -> None:
    pixels = scene(*size)
    jpeg = encode(GREY_JPEG, pixels, 80)
    own = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, 80])[1].tobytes()
    assert decoded(jpeg).shape == pixels.shape
    assert cv2.PSNR(decoded(jpeg), pixels) >= cv2.PSNR(decoded(own), pixels) - 0.1
    assert len(jpeg) <= len(own) * 1.02


def test_rows_can_be_apart() -> None:
    pixels = scene(300, 200)
    apart = pixels[10:90, 7:120]
    assert encode(GREY_JPEG, apart, 90) == encode(GREY_JPEG, apart.copy(), 90)


def test_depth_has_the_bytes_of_another_encoder() -> None:
    random = np.random.default_rng(1)
    mm = (random.integers(0, 65536, (48, 64)) * (random.random((48, 64)) < 0.8)).astype(np.uint16)
    metres = (mm / 1000 + random.uniform(-4e-4, 4e-4, mm.shape)).astype(np.float32)
    metres[mm == 0] = np.nan
    assert encode(DEPTH_RVL, metres) == compressed_depth(mm)


def test_a_refusal_says_why() -> None:
    with pytest.raises(EncoderError, match="grey_jpeg: quality 0, but it is 1 to 100"):
        encode(GREY_JPEG, scene(8, 8), 0)

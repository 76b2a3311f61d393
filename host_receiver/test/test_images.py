"""Pixels of plain and compressed images, against OpenCV and an encoder of the paper on RVL."""

import struct
from contextlib import suppress
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

from compressed_images import FORMAT, compressed_depth, with_scans, words
from ml2_tools.images.image_topic import camera_namespace, image_topic
from ml2_tools.images.pixels import encoding_of, grey_of, pixels_of
from ml2_tools.images.rvl import decode_rvl
from ml2_tools.images.size import compressed_size

GREY, COLOUR = "mono8; jpeg compressed mono8", "rgb8; jpeg compressed bgr8"
HEAD = struct.pack("<iff", 0, 0, 0)


@dataclass
class Compressed:
    """A CompressedImage, as any library decodes it."""

    format: str
    data: Any


def picture(*shape: int) -> NDArray[np.uint8]:
    noise = np.random.default_rng(1).integers(0, 256, shape).astype(np.uint8)
    return cv2.GaussianBlur(noise, (0, 0), 2).astype(np.uint8)


def jpeg(pixels: NDArray[np.uint8]) -> bytes:
    return cv2.imencode(".jpg", pixels)[1].tobytes()


def millimetres(data: bytes) -> list[list[int]]:
    """Returns depth in mm, 0 for NaN; each is at most half a micrometre off a whole number."""
    mm = pixels_of(Compressed(FORMAT, data)).astype(np.float64) * 1000
    whole = np.nan_to_num(np.round(mm))
    assert np.nanmax(np.abs(mm - whole), initial=0) < 0.005
    return whole.astype(int).tolist()  # type: ignore[no-any-return]


def test_a_grey_jpeg_has_one_channel() -> None:
    data = jpeg(picture(48, 64))
    found = pixels_of(Compressed(GREY, data))
    expected = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert (found.dtype.name, found.shape, encoding_of(found)) == ("uint8", (48, 64), "mono8")
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("format", [COLOUR, "jpeg"])
def test_a_colour_jpeg_has_three_channels_and_a_grey_version(format: str) -> None:
    data = jpeg(picture(48, 64, 3))
    message = Compressed(format, data)
    found = pixels_of(message)
    expected = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert (found.shape, encoding_of(found)) == ((48, 64, 3), "bgr8")
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(grey_of(message), cv2.cvtColor(expected, cv2.COLOR_BGR2GRAY))


def test_a_jpeg_keeps_the_geometry_of_its_camera_info() -> None:
    """EXIF asks to show the image turned by 90 degrees."""
    data = jpeg(picture(48, 64))
    entry = struct.pack(">HHIHH", 0x0112, 3, 1, 6, 0)
    exif = b"Exif\0\0MM\0*\0\0\0\x08\0\x01" + entry + bytes(4)
    segment = struct.pack(">BBH", 0xFF, 0xE1, 2 + len(exif)) + exif
    turned = np.frombuffer(data[:2] + segment + data[2:], np.uint8)
    assert cv2.imdecode(turned, cv2.IMREAD_GRAYSCALE).shape == (64, 48), "OpenCV reads the EXIF"
    for format, shape in ((GREY, (48, 64)), (COLOUR, (48, 64, 3))):
        assert pixels_of(Compressed(format, turned.tobytes())).shape == shape


def test_the_size_of_a_jpeg_is_read_without_decoding_it() -> None:
    for pixels in (picture(48, 64), picture(50, 61, 3)):
        for options in ((), (cv2.IMWRITE_JPEG_PROGRESSIVE, 1)):
            data = cv2.imencode(".jpg", pixels, options)[1].tobytes()
            assert compressed_size("jpeg", data) == pixels.shape[1::-1]


def resized(data: bytes, width: int, height: int) -> bytes:
    """Returns a JPEG whose head says another size."""
    at = data.index(b"\xff\xc0") + 5
    return data[:at] + struct.pack(">HH", height, width) + data[at + 4 :]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "expected a JPEG, found 0 other bytes"),
        (cv2.imencode(".png", picture(4, 4))[1].tobytes(), "expected a JPEG, found .* other bytes"),
        (resized(jpeg(picture(8, 8)), 65500, 65500), "expected 1 to 12582912 pixels, found 65500x"),
        (resized(jpeg(picture(8, 8)), 8, 0), "found 8x0"),
        (b"\xff\xd8", "with a size"),
        (b"\xff\xd8\xff", "with a size"),
        (b"\xff\xd8\xff\xd9" + bytes(99), "with a size"),
        (b"\xff\xd8\xff\xe0\0\0" + bytes(99), "with a size"),
        (b"\xff\xd8" + b"\xff" * 1000 + jpeg(picture(8, 8))[2:], "with a size"),
        (jpeg(picture(64, 64))[:300], "expected a JPEG"),
    ],
)
def test_what_is_no_jpeg_is_refused(
    monkeypatch: pytest.MonkeyPatch, data: bytes, words: str
) -> None:
    if "12582912" in words:
        monkeypatch.delattr(cv2, "imdecode")  # it would take the memory
    for format in (GREY, ""):
        with pytest.raises(ValueError, match=words):
            pixels_of(Compressed(format, data))


@given(st.data())
def test_any_damage_to_a_jpeg_is_a_value_error_or_a_picture(data: st.DataObject) -> None:
    broken = bytearray(jpeg(picture(16, 24)))
    for _ in range(data.draw(st.integers(1, 6))):
        broken[data.draw(st.integers(0, len(broken) - 1))] = data.draw(st.integers(0, 255))
    del broken[data.draw(st.integers(1, len(broken))) :]
    with suppress(ValueError):
        pixels = pixels_of(Compressed(GREY, bytes(broken)))
        assert pixels.shape[::-1] == compressed_size(GREY, broken)


IMAGES = arrays.arrays(
    np.uint16,
    st.tuples(st.integers(1, 12), st.integers(1, 12)),
    elements=st.one_of(
        st.just(0), st.integers(990, 1010), st.integers(0, 65535), st.sampled_from([1, 65535])
    ),
)


@given(IMAGES)
def test_depth_is_exactly_the_millimetres_that_were_compressed(mm: NDArray[np.uint16]) -> None:
    data = compressed_depth(mm)
    assert millimetres(data) == mm.tolist()
    assert compressed_size(FORMAT, data) == mm.shape[::-1]


def test_depth_is_metres_and_nan_where_it_is_invalid() -> None:
    found = pixels_of(Compressed(FORMAT, compressed_depth(np.array([[0, 1500, 1]], np.uint16))))
    assert (found.dtype.name, encoding_of(found)) == ("float32", "32FC1")
    np.testing.assert_array_equal(found, np.array([[np.nan, 1.5, 0.001]], np.float32))


def test_depth_of_the_size_of_the_headset_is_read() -> None:
    random = np.random.default_rng(1)
    mm = random.normal(1200, 5, (480, 544)).astype(np.uint16)
    mm[random.random(mm.shape) < 0.1] = 0
    assert millimetres(compressed_depth(mm)) == mm.tolist()
    nothing = np.zeros_like(mm)
    assert len(compressed_depth(nothing)) == 24, "an image without depth has two values"
    assert millimetres(compressed_depth(nothing)) == nothing.tolist()


def test_a_picture_of_the_paper_is_read() -> None:
    """By hand: one invalid pixel, then 1000, 1003 and 1001: +1000 is 2000, +3 is 6, -2 is 3."""
    nibbles = "1" + "3" + "8af3" + "6" + "3"
    data = HEAD + struct.pack("<III", 4, 1, int(nibbles, 16))
    assert millimetres(data) == [[0, 1000, 1003, 1001]]


VALID = compressed_depth(np.array([[0, 1000, 1003, 1001]], np.uint16))


def rvl(width: int, height: int, *values: int) -> bytes:
    return HEAD + struct.pack("<II", width, height) + words(values)


@pytest.mark.parametrize(
    ("format", "data", "found"),
    [
        ("16UC1; compressedDepth png", VALID, f"expected '{FORMAT}', found '16UC1; compressedDep"),
        ("16UC1; compressedDepth", VALID, "found '16UC1; compressedDepth'"),
        ("32FC1; compressedDepth rvl", VALID, "found '32FC1; compressedDepth rvl'"),
        (FORMAT, b"", "expected a head of 20 bytes, found 0"),
        (FORMAT, VALID[:19], "expected a head of 20 bytes, found 19"),
        (FORMAT, struct.pack("<iff", 0, 100, 1) + VALID[12:], r"found \(0, 100.0, 1.0\)"),
        (FORMAT, struct.pack("<iff", 1, 0, 0) + VALID[12:], r"found \(1, 0.0, 0.0\)"),
        (FORMAT, struct.pack("<iff", 0, np.nan, 0) + VALID[12:], r"found \(0, nan, 0.0\)"),
        (FORMAT, rvl(0, 4, 0, 0), "expected 1 to 12582912 pixels, found 0x4"),
        (FORMAT, rvl(4097, 3072, 0, 0), "expected 1 to 12582912 pixels, found 4097x3072"),
        (FORMAT, rvl(2**32 - 1, 2**32 - 1, 0, 0), "found 4294967295x4294967295"),
        (FORMAT, VALID[:20], "expected RVL words, at most 24 bytes, found 0 bytes"),
        (FORMAT, VALID[:23], "found 3 bytes"),
        (FORMAT, VALID + bytes(24), "expected RVL words, at most 24 bytes, found 28 bytes"),
        (FORMAT, rvl(3, 1, 4, 0), "expected 3 pixels in RVL, found 4"),
        (FORMAT, rvl(5, 1, 1, 3, 2000, 6, 3), "expected 5 pixels in RVL, found 4"),
        (FORMAT, rvl(3, 1, 1, 3, 2000, 6, 3), "expected 3 pixels in RVL, found 4"),
        (FORMAT, rvl(99, 1, 0, 99, 2000, 6, 3), "expected 99 pixels in RVL, found an end in the"),
        (FORMAT, rvl(4096, 3072, 0, 4096 * 3072), "found an end in the last of them"),
        (FORMAT, rvl(9, 9, *[0] * 240), "expected at most 50 runs of 81 pixels in RVL, found more"),
        (FORMAT, rvl(2, 1, 0, 2, 2000, 1999), "expected valid pixels of 1 to 65535 .* found 0 to"),
        (FORMAT, rvl(2, 1, 0, 2, 1, 2), "found -1 to 0"),
        (FORMAT, rvl(1, 1, 0, 1, 2 * 65536), "found 65536 to 65536"),
        (FORMAT, VALID + b"\x08\0\0\0", "expected the end of a value .* found its start"),
        (FORMAT, VALID[:20] + b"\xff" * 4, "expected the end of a value .* found its start"),
        (FORMAT, VALID[:20] + b"\xff" * 8 + bytes(4), "at most 8 nibbles in a value, found 17"),
    ],
)
def test_depth_that_contradicts_itself_is_refused(format: str, data: bytes, found: str) -> None:
    with pytest.raises(ValueError, match=found):
        pixels_of(Compressed(format, data))


@given(st.integers(1, 40), st.integers(1, 40), st.binary(max_size=400))
def test_any_bytes_are_a_value_error_or_depth_of_the_size_they_say(
    width: int, height: int, data: bytes
) -> None:
    with suppress(ValueError):
        found = pixels_of(Compressed(FORMAT, HEAD + struct.pack("<II", width, height) + data))
        assert found.shape == (height, width)


@given(IMAGES, st.data())
def test_any_damage_to_depth_is_a_value_error_or_depth(
    mm: NDArray[np.uint16], data: st.DataObject
) -> None:
    broken = bytearray(compressed_depth(mm))
    for _ in range(data.draw(st.integers(1, 4))):
        broken[data.draw(st.integers(20, len(broken) - 1))] = data.draw(st.integers(0, 255))
    del broken[data.draw(st.integers(20, len(broken))) :]
    with suppress(ValueError):
        assert pixels_of(Compressed(FORMAT, broken)).shape == mm.shape


@given(st.integers(0, 100), st.binary(max_size=200))
def test_any_words_are_a_value_error_or_as_many_pixels_as_asked_for(
    count: int, data: bytes
) -> None:
    with suppress(ValueError):
        assert decode_rvl(data, count).shape == (count,)


def test_the_size_of_another_format_is_not_known() -> None:
    for format in ("", "png", "16UC1; compressedDepth png", "rgb8; png compressed bgr8"):
        assert compressed_size(format, b"") is None


def test_video_is_refused_with_what_to_do() -> None:
    packet = SimpleNamespace(encoding="h264;yuv420p;mono8;mono8", pts=1, data=b"\0\0\1")
    with pytest.raises(ValueError, match=r"^expected an image, found video: use another format"):
        pixels_of(packet)


@pytest.mark.parametrize(
    ("camera", "existing", "expected"),
    [
        ("world_left", ["image_raw"], "image_raw"),
        ("world_left", ["image_raw/compressed"], "image_raw/compressed"),
        ("world_left", ["image_raw", "image_raw/compressed"], "image_raw/compressed"),
        ("world_left", ["image_raw/ffmpeg"], "image_raw/ffmpeg"),
        ("color", ["image_raw/ffmpeg"], "image_raw/ffmpeg"),
        ("world_left", [], "image_raw"),
        ("eye_nasal_left", ["image_raw/compressed"], "image_raw/compressed"),
        ("depth", ["image_raw/compressedDepth"], "image_raw/compressedDepth"),
        ("depth", ["image_raw/compressed"], "image_raw"),
        ("color", [], "image_raw/compressed"),
    ],
)
def test_the_image_topic_is_the_one_that_exists(
    camera: str, existing: list[str], expected: str
) -> None:
    names = {f"/p/{camera}/{it}" for it in existing}
    assert image_topic(camera, "/p", names.__contains__).name == f"{camera}/{expected}"
    assert camera_namespace(f"/p/{camera}/{expected}") == f"/p/{camera}"


@pytest.mark.parametrize("format", ["jpeg", GREY, COLOUR])
def test_scans_are_counted_before_they_are_decoded(
    format: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(cv2, "imdecode")
    data = jpeg(picture(64, 64))
    # Behind a comment that is said to hold them, a decoder that has lost its place finds them.
    hidden = with_scans(data, 1)[:-2] + b"\xff\xfe\xff\xff" + b"\xff\xda\0\x02" * 40
    for scans in (with_scans(data, 33), with_scans(data, 1000), hidden):
        with pytest.raises(ValueError, match="at most 32 scans in a JPEG"):
            pixels_of(Compressed(format, scans))


def test_a_progressive_jpeg_has_few_enough_scans() -> None:
    for pixels in (picture(480, 640), picture(480, 640, 3)):
        data = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()
        assert data.count(b"\xff\xda") > 4
        assert compressed_size("jpeg", data) == pixels.shape[1::-1]


def test_a_thumbnail_in_front_is_none_of_the_scans() -> None:
    data = jpeg(picture(48, 64))
    exif = b"\xff\xe1" + struct.pack(">H", 2 + 4 * 99) + b"\xff\xda\xff\xc0" * 99
    assert compressed_size("jpeg", data[:2] + exif + data[2:]) == (64, 48)


SEGMENT = st.tuples(st.integers(0, 255), st.integers(0, 65535), st.binary(max_size=20))


@given(st.lists(SEGMENT, max_size=20), st.booleans())
def test_any_segments_are_a_size_within_bounds_or_a_value_error(
    segments: list[tuple[int, int, bytes]], is_honest: bool
) -> None:
    data = b"\xff\xd8" + b"".join(
        struct.pack(">BBH", 0xFF, marker, len(body) + 2 if is_honest else length) + body
        for marker, length, body in segments
    )
    with suppress(ValueError):
        width, height = compressed_size("jpeg", data) or (0, 0)
        assert 0 < width * height <= 4096 * 3072
        assert data.count(b"\xff\xda") >= 1


def test_many_segments_are_refused_in_no_time() -> None:
    comments = b"\xff\xd8" + b"\xff\xfe\0\x02" * 4_000_000
    with pytest.raises(ValueError, match="with a size"):
        compressed_size("jpeg", comments)

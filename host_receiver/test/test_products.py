"""Products of captures, fed by hand."""

import json
from typing import Any

import cv2
import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, PointCloud2
from std_msgs.msg import Header

from camera_messages import camera_info, stamped
from compressed_images import FORMAT, compressed_depth
from ml2_tools.geometry.camera import metadata_stamp_ns
from ml2_tools.geometry.pose import pose_of
from ml2_tools.images.pixels import pixels_of
from ml2_tools.monitoring.losses import Losses
from ml2_tools.products import product
from ml2_tools.products.captures import Captures
from ml2_tools.products.product import Points, Raw, Rectified, Registered, Shared, all_products

WIDTH, HEIGHT = 8, 6
MS = 1_000_000
STILL = np.eye(4)
INTRINSICS = {
    "width": WIDTH,
    "height": HEIGHT,
    "focal_length": [8.0, 8.0],
    "principal_point": [3.5, 2.5],
    "distortion_model": "plumb_bob",
    "distortion": [0.0] * 5,
}


def header(stamp_ns: int, camera: str) -> Header:
    return stamped(f"{camera}_optical_frame", stamp_ns)


def info(stamp_ns: int, camera: str) -> CameraInfo:
    k = (8.0, 0, 3.5, 0, 8, 2.5, 0, 0, 1)
    return camera_info(header(stamp_ns, camera), (WIDTH, HEIGHT), "plumb_bob", [0.0] * 5, k)


def depth(stamp_ns: int, z: float = 2.0) -> Image:
    data = np.full((HEIGHT, WIDTH), z, np.float32)
    return Image(
        header=header(stamp_ns, "depth"),
        width=WIDTH,
        height=HEIGHT,
        encoding="32FC1",
        step=4 * WIDTH,
        data=data.tobytes(),
    )


def jpeg(stamp_ns: int, bgr: tuple[int, int, int]) -> CompressedImage:
    data = cv2.imencode(".jpg", np.full((HEIGHT, WIDTH, 3), bgr, np.uint8))[1].tobytes()
    return CompressedImage(header=header(stamp_ns, "color"), format="jpeg", data=data)


def depth16(stamp_ns: int, mm: int = 2000) -> CompressedImage:
    data = compressed_depth(np.full((HEIGHT, WIDTH), mm, np.uint16))
    return CompressedImage(header=header(stamp_ns, "depth"), format=FORMAT, data=data)


def grey_jpeg(stamp_ns: int) -> CompressedImage:
    pixels = np.random.default_rng(1).integers(0, 256, (HEIGHT, WIDTH), np.uint8)
    data = cv2.imencode(".jpg", pixels)[1].tobytes()
    format = "mono8; jpeg compressed mono8"
    return CompressedImage(header=header(stamp_ns, "world_left"), format=format, data=data)


def add(product: Any, camera: str, stamp_ns: int, **parts: Any) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for part, value in parts.items():
        made |= product.add(camera, part, stamp_ns, value)
    return made


def cloud(message: PointCloud2) -> np.ndarray:
    """Reads the points by the fields that the message lists."""
    types = {field.name: (np.float32, field.offset) for field in message.fields}
    whole = np.dtype(
        {
            "names": list(types),
            "formats": [type for type, _ in types.values()],
            "offsets": [offset for _, offset in types.values()],
            "itemsize": message.point_step,
        }
    )
    assert message.row_step == message.point_step * message.width
    return np.frombuffer(bytes(message.data), whole).reshape(message.height, message.width)


def test_a_cloud_without_colours_needs_no_transform() -> None:
    made = add(
        Points(Shared(is_radial=False)), "depth", 5, image=depth(5), camera_info=info(5, "depth")
    )
    points = cloud(made["depth/points"])
    assert points.dtype.names == ("x", "y", "z")
    assert made["depth/points"].header == header(5, "depth")
    assert points[0, 0].tolist() == pytest.approx((2 * -3.5 / 8, 2 * -2.5 / 8, 2))


def test_a_coloured_cloud_has_the_colours_of_the_nearest_image() -> None:
    product = Points(Shared(is_radial=False))
    product.colour(True)
    for stamp_ns, bgr in [(10 * MS, (0, 0, 255)), (40 * MS, (255, 0, 0))]:
        parts = {"image": jpeg(stamp_ns, bgr), "camera_info": info(stamp_ns, "color")}
        assert not add(product, "color", stamp_ns, **parts, transform=STILL)
    at = 32 * MS
    parts = {"transform": STILL, "camera_info": info(at, "depth"), "image": depth(at)}
    rgb = cloud(add(product, "depth", at, **parts)["depth/points"])["rgb"].view(np.uint32)
    assert (rgb >> 16 < 3).all()
    assert (rgb & 0xFF > 250).all()


def test_a_cloud_goes_out_uncoloured_and_counted_when_no_image_is_near() -> None:
    shared = Shared(is_radial=False)
    product = Points(shared)
    product.colour(True)
    parts = {"transform": STILL, "camera_info": info(0, "depth"), "image": depth(0)}
    assert cloud(add(product, "depth", 0, **parts)["depth/points"]).dtype.names == ("x", "y", "z")
    assert sum(shared.losses.counts().values()) == 1


def test_nothing_is_made_of_depth_before_the_settings_say_what_it_is() -> None:
    with pytest.raises(ValueError, match="nothing came on config"):
        add(Points(Shared()), "depth", 0, image=depth(0), camera_info=info(0, "depth"))


def test_radial_depth_becomes_z() -> None:
    shared = Shared(is_radial=True)
    made = add(Points(shared), "depth", 0, image=depth(0), camera_info=info(0, "depth"))
    points = cloud(made["depth/points"])
    lengths = np.sqrt(sum(points[axis] ** 2 for axis in "xyz"))
    assert np.allclose(lengths, 2, atol=1e-5)


@pytest.mark.parametrize("is_radial", [False, True])
def test_products_of_compressed_depth_are_those_of_plain_depth(is_radial: bool) -> None:
    made = []
    for image in (depth(9), depth16(9)):
        points = Points(Shared(is_radial=is_radial))
        messages = add(points, "depth", 9, camera_info=info(9, "depth"), image=image)
        aligned = Registered(Shared(is_radial=is_radial), "color", ("camera_info", "transform"))
        add(aligned, "color", 7, camera_info=info(7, "color"), transform=STILL)
        parts = {"transform": STILL, "camera_info": info(9, "depth"), "image": image}
        made.append(messages | add(aligned, "depth", 9, **parts))
    assert made[0] == made[1]


def test_a_compressed_image_is_rectified() -> None:
    image, raw = grey_jpeg(5), image_of(grey_jpeg(5))
    made = []
    for each in (image, raw):
        rectified = Rectified(Shared(), "world_left")
        metadata = json.dumps({"intrinsics": INTRINSICS})
        parts = {"camera_info": info(5, "world_left"), "metadata": metadata}
        made.append(add(rectified, "world_left", 5, image=each, **parts))
    assert made[0] == made[1]
    assert made[0]["world_left/image_rect"].encoding == "mono8"


def image_of(message: CompressedImage) -> Image:
    """Decodes with OpenCV."""
    data = np.frombuffer(message.data, np.uint8)
    pixels = cv2.imdecode(data, cv2.IMREAD_UNCHANGED)
    size = {"width": WIDTH, "height": HEIGHT, "step": WIDTH, "encoding": "mono8"}
    return Image(header=message.header, data=pixels.tobytes(), **size)


@pytest.mark.parametrize(
    ("camera", "compressed", "raw"),
    [
        ("world_left", grey_jpeg(5), image_of(grey_jpeg(5))),
        ("eye_nasal_left", grey_jpeg(5), image_of(grey_jpeg(5))),
        ("depth", depth16(5, 1234), depth(5, 1.234)),
    ],
)
def test_a_compressed_image_becomes_raw(
    camera: str, compressed: CompressedImage, raw: Image
) -> None:
    """Radial depth stays radial, because the raw image is what the headset publishes as Depth32."""
    made = add(Raw(Shared(is_radial=True), camera), camera, 5, image=compressed)
    assert made == {f"{camera}/image_raw": raw}


def test_nothing_is_made_of_an_image_that_is_raw_already() -> None:
    assert not add(Raw(Shared(), "depth"), "depth", 5, image=depth(5))


def test_every_stream_that_may_be_compressed_becomes_raw() -> None:
    raw = {topic for it in all_products(Shared()) if isinstance(it, Raw) for topic in it.types}
    eyes = [f"eye_{place}_{side}" for place in ("nasal", "temple") for side in ("left", "right")]
    worlds = [f"world_{place}" for place in ("left", "center", "right")]
    assert raw == {f"{camera}/image_raw" for camera in (*eyes, *worlds, "depth")}


def test_an_image_that_several_products_need_is_decoded_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    decoded: list[Any] = []

    def decode(message: Any) -> Any:
        decoded.append(message)
        return pixels_of(message)

    monkeypatch.setattr(product, "pixels_of", decode)
    shared = Shared(is_radial=False)
    points, raw = Points(shared), Raw(shared, "depth")
    for image, other in ((depth16(5), grey_jpeg(5)), (depth16(6), grey_jpeg(6))):
        stamp_ns = image.header.stamp.nanosec
        assert add(points, "depth", stamp_ns, image=image, camera_info=info(stamp_ns, "depth"))
        assert add(Raw(shared, "world_left"), "world_left", stamp_ns, image=other)
        assert add(raw, "depth", stamp_ns, image=image)
    assert len(decoded) == 4


def test_registered_depth_has_the_stamp_and_camera_info_of_the_other_camera() -> None:
    product = Registered(Shared(is_radial=False), "color", ("camera_info", "transform"))
    add(product, "color", 7 * MS, camera_info=info(7 * MS, "color"), transform=STILL)
    at = 9 * MS
    parts = {"transform": STILL, "camera_info": info(at, "depth"), "image": depth(at)}
    made = add(product, "depth", at, **parts)
    assert made["aligned_depth_to_color/camera_info"] == info(7 * MS, "color")
    image = made["aligned_depth_to_color/image_raw"]
    assert image.header == header(7 * MS, "color")
    assert (pixels_of(image) == 2).all()


def test_an_image_gets_registered_depth_once() -> None:
    shared = Shared(is_radial=False)
    product = Registered(shared, "color", ("camera_info", "transform"))
    add(product, "color", 7, camera_info=info(7, "color"), transform=STILL)
    made = [
        add(product, "depth", at, transform=STILL, camera_info=info(at, "depth"), image=depth(at))
        for at in (8, 9)
    ]
    assert [bool(it) for it in made] == [True, False]
    assert sum(shared.losses.counts().values()) == 1


def test_motion_between_two_captures_is_taken_out() -> None:
    """The other camera is 0.25 m to the right by the time of its capture: 1 px at 2 m."""
    product = Registered(Shared(is_radial=False), "color", ("camera_info", "transform"))
    moved = np.eye(4)
    moved[0, 3] = 0.25
    add(product, "color", 7, camera_info=info(7, "color"), transform=moved)
    image = depth(8)
    z = np.array(pixels_of(image))
    z[:, 4] = 1.5
    z[:, 5:] = np.nan
    image.data = z.tobytes()
    made = add(product, "depth", 8, transform=STILL, camera_info=info(8, "depth"), image=image)
    found = pixels_of(made["aligned_depth_to_color/image_raw"])
    assert (found[:, 3] == 1.5).all()
    assert (found[:, :3] == 2).all()
    assert np.isnan(found[:, 4:]).all()


def test_captures_that_stay_incomplete_are_counted_by_what_was_missing() -> None:
    shared = Shared(is_radial=False)
    captures = Captures("color", ("image", "transform"), shared.losses)
    for stamp_ns in range(100):
        captures.add("image", stamp_ns, object())
    assert shared.losses.counts() == {"color: no transform for an image": 100 - 64}


def test_transforms_that_no_image_has_are_no_loss() -> None:
    shared = Shared(is_radial=False)
    captures = Captures("color", ("image", "transform"), shared.losses)
    for stamp_ns in range(1000):
        captures.add("transform", stamp_ns, object())
    assert not shared.losses.counts()


def test_losses_are_bounded_in_number_and_length() -> None:
    losses = Losses()
    for reason in range(1000):
        losses.add(f"{reason} " + "x" * 10_000)
    counts = losses.counts()
    assert len(counts) == 101
    assert counts[Losses.OTHER] == 900
    assert max(map(len, counts)) == 200


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"data": b""}, "found 0"),
        ({"data": b"1234"}, "found 4"),
        ({"height": 10**9}, "expected the bytes of"),
        ({"step": 3}, "expected the bytes of"),
        ({"encoding": "mono16"}, "expected mono8 or 32FC1"),
        ({"is_bigendian": 1}, "little endian"),
    ],
)
def test_images_that_contradict_themselves_are_refused(
    change: dict[str, Any], message: str
) -> None:
    image = depth(0)
    for name, value in change.items():
        setattr(image, name, value)
    with pytest.raises(ValueError, match=message):
        add(Points(Shared(is_radial=False)), "depth", 0, image=image, camera_info=info(0, "depth"))


def test_padded_rows_are_left_out() -> None:
    image = Image(height=2, width=3, step=5, encoding="mono8", data=bytes(range(10)))
    assert pixels_of(image).tolist() == [[0, 1, 2], [5, 6, 7]]


@pytest.mark.parametrize(
    "metadata",
    [
        "",
        "[]",
        "3",
        '{"stamp": 3}',
        '{"stamp": {"sec": 1}}',
        '{"stamp": {"sec": 1e999, "nanosec": 1}}',
    ],
)
def test_metadata_without_a_stamp_are_refused(metadata: str) -> None:
    with pytest.raises(ValueError, match="metadata without a stamp"):
        metadata_stamp_ns(metadata)


def test_a_transform_that_is_no_rotation_is_refused() -> None:
    from geometry_msgs.msg import Transform

    transform = Transform()
    assert (pose_of(transform) == np.eye(4)).all()
    transform.rotation.w = 0.5
    with pytest.raises(ValueError, match="unit quaternion"):
        pose_of(transform)

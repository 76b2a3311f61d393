"""Measures wall and CPU time in ms per frame of each product, from its inputs to its message.

Depth is 544 x 480, colour is a JPEG of 1920 x 1080, world images are 1016 x 1016. What the headset
compresses has the noise of codecs_bench.py and is encoded by the library that ships: a slanted
wall, and soft shapes. Nothing is received or published. Results are medians; maps that are made
once per calibration do not count.
"""

import functools
import json
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from compressed_images import FORMAT
from ml2_tools.products.product import (
    Points,
    Product,
    Raw,
    Rectified,
    Registered,
    Shared,
)
from native_encoders import DEPTH_RVL, GREY_JPEG, encode

RESULTS = Path(__file__).resolve().parents[2] / "build" / "bench" / "products.json"
REPETITIONS = 20
FRAME_NS = 33_000_000
GREY, QUALITY = "mono8; jpeg compressed mono8", 80
DEPTH, COLOR, WORLD = (544, 480, 370.0), (1920, 1080, 1400.0), (1016, 1016, 580.0)
WORLD_METADATA = {
    "focal_length": [580.0, 580.0],
    "principal_point": [508.0, 508.0],
    "width": 1016,
    "height": 1016,
    "distortion_model": "fisheye_tangential",
    "distortion": [0.02, -0.01, 3e-3, -1e-3, 1e-3, -2e-3],
}


def main() -> None:
    """Runs each product and writes build/bench/products.json."""
    shared = Shared(is_radial=False)
    coloured = Points(shared)
    coloured.colour(True)
    exact = ("camera_info", "metadata", "transform")
    products: dict[str, tuple[Product, Callable[[Product, int], None]]] = {
        "points": (Points(shared), feed_depth),
        "points_from_depth16": (Points(shared), feed_compressed_depth),
        "coloured_points": (coloured, feed_both),
        "world_raw_from_jpeg": (Raw(shared, "world_left"), feed_compressed_world),
        "world_rectified": (Rectified(shared, "world_left"), feed_world),
        "depth_to_color": (Registered(shared, "color", ("camera_info", "transform")), feed_both),
        "depth_to_world": (Registered(shared, "world_left", exact), feed_world_and_depth),
    }
    results: dict[str, float | int] = {}
    for name, (product, feed) in products.items():
        wall_ms, cpu_ms = measure(functools.partial(feed, product))
        results |= {f"{name}_ms": wall_ms, f"{name}_cpu_ms": cpu_ms}
    results |= {"opencv_threads": cv2.getNumThreads(), "repetitions": REPETITIONS}
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(results, indent=2) + "\n")


def measure(run: Callable[[int], None]) -> tuple[float, float]:
    """Returns the medians of wall and CPU time in ms, after a first run."""
    run(1)
    times = []
    for number in range(2, REPETITIONS + 2):
        began_s, began_cpu_s = time.perf_counter(), time.process_time()
        run(number)
        times.append((time.perf_counter() - began_s, time.process_time() - began_cpu_s))
    wall_s, cpu_s = (statistics.median(column) for column in zip(*times, strict=True))
    return wall_s * 1000, cpu_s * 1000


def feed_depth(product: Product, number: int) -> None:
    feed(product, "depth", number, image=depth_image, camera_info=info(DEPTH, "plumb_bob"))


def feed_compressed_depth(product: Product, number: int) -> None:
    image = CompressedImage(format=FORMAT, data=depth16)
    feed(product, "depth", number, image=image, camera_info=info(DEPTH, "plumb_bob"))


def feed_compressed_world(product: Product, number: int) -> None:
    feed(product, "world_left", number, image=CompressedImage(format=GREY, data=world_jpeg))


def feed_color(product: Product, number: int) -> None:
    # A new message each time, because the same message is decoded only once.
    image = CompressedImage(data=jpeg)
    feed(product, "color", number, image=image, camera_info=info(COLOR, "plumb_bob"))


def feed_both(product: Product, number: int) -> None:
    feed_color(product, number)
    feed_depth(product, number)


def feed_world(product: Product, number: int) -> None:
    camera_info = info(WORLD, "equidistant")
    feed(product, "world_left", number, image=world_image, camera_info=camera_info)


def feed_world_and_depth(product: Product, number: int) -> None:
    feed_world(product, number)
    feed_depth(product, number)


def feed(product: Product, camera: str, number: int, **parts: Any) -> None:
    metadata = json.dumps({"intrinsics": WORLD_METADATA})
    made: dict[str, Any] = {}
    for part, value in {**parts, "metadata": metadata, "transform": np.eye(4)}.items():
        made |= product.add(camera, part, number * FRAME_NS, value)
    last = list(product.inputs)[0 if "depth" in product.inputs else -1]
    assert made or camera != last, f"{product} made nothing"


def info(size: tuple[int, int, float], model: str) -> CameraInfo:
    width, height, f = size
    cx, cy = width / 2, height / 2
    d = [0.02, -0.01, 3e-3, -1e-3] if model == "equidistant" else [0.1, -0.1, 1e-3, -1e-3, 0.02]
    k = [f, 0, cx, 0, f, cy, 0, 0, 1]
    p = [f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0]
    return CameraInfo(
        width=width,
        height=height,
        distortion_model=model,
        d=d,
        k=list(map(float, k)),
        r=np.eye(3).ravel().tolist(),
        p=list(map(float, p)),
    )


def image(pixels: np.ndarray[Any, Any], encoding: str) -> Image:
    height, width = pixels.shape
    step = pixels.itemsize * width
    return Image(height=height, width=width, encoding=encoding, step=step, data=pixels.tobytes())


noise = np.random.default_rng(1)
depth_image = image(noise.uniform(0.5, 5, DEPTH[1::-1]).astype(np.float32), "32FC1")
world_image = image(noise.integers(0, 255, WORLD[1::-1]).astype(np.uint8), "mono8")
scene = cv2.GaussianBlur(noise.integers(0, 255, (1080, 1920, 3)).astype(np.uint8), (0, 0), 5)
jpeg = cv2.imencode(".jpg", scene)[1].tobytes()
wall = np.linspace(0.5, 3, DEPTH[0]) + np.zeros(DEPTH[1::-1])
wall += noise.normal(0, 1, wall.shape) * (0.001 + 0.003 * wall**2)
depth16 = encode(DEPTH_RVL, wall.astype(np.float32))
grey = 128 + 10 * (cv2.GaussianBlur(noise.uniform(0, 255, WORLD[1::-1]), (0, 0), 5) - 127.5)
grey += noise.normal(0, 2, grey.shape)
world_jpeg = encode(GREY_JPEG, grey.clip(0, 255).astype(np.uint8), QUALITY)

if __name__ == "__main__":
    main()

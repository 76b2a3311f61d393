#!/usr/bin/env python3
"""Draws the moving picture of README.md from a recording of the demo.

The picture shows the world camera, the colour camera, the depth (near is red) and the path of the
head from above. These commands renew it:

    host_receiver/ml2-receiver record build/walk --no-ros --insecure --config config/demo.yaml
    ml2-sensors-aar/simulator/ml2-headset --insecure --receiver 127.0.0.1:7755 --duration 25
    host_receiver/environment/run.sh python3 host_receiver/demo/picture.py build/walk docs/demo.gif
"""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from contact_sheet import decoded_image
from ml2_tools.bags.bag_reader import Bag
from ml2_tools.bags.decoding import decoder

Pixels = NDArray[np.uint8]
# x, y in metres in the world, and the heading in radians.
Path2d = list[tuple[float, float, float]]

PREFIX = "/magic_leap2/"
CAMERAS = {
    "world_center/image_raw/compressed": "world_center/image_raw",
    "color/image_raw/compressed": "color/image_raw",
    "depth/image_raw/compressedDepth": "depth/image_raw",
}
HEAD = "head_pose"
FRAMES_PER_S = 8
TILE = (240, 180)
LABEL_HEIGHT = 22
BACKGROUND, TEXT = (27, 22, 17), (220, 215, 205)  # BGR
PATH, PATH_AHEAD, HEADING = (235, 160, 60), (70, 60, 50), (90, 200, 255)
MAX_BYTES = 2_000_000


@dataclass
class Moment:
    """The latest message of each camera and the path of the head so far, at one instant."""

    payloads: dict[str, bytes]
    path: Path2d


@dataclass
class Walk:
    """The state of the recording up to the present message."""

    latest: dict[str, bytes] = field(default_factory=dict)
    path: Path2d = field(default_factory=list)

    def take(self, topic: str, payload: bytes) -> None:
        if topic == HEAD:
            pose = decoder("geometry_msgs/msg/PoseStamped")(payload).pose
            self.path.append((pose.position.x, pose.position.y, _yaw(pose.orientation)))
        elif topic in CAMERAS:
            self.latest[topic] = payload


def moments(bag: Bag, seconds: float) -> Iterator[Moment]:
    """Yields FRAMES_PER_S moments per second, once every camera has delivered."""
    walk = Walk()
    first_ns: int | None = None
    count = 0
    for message in bag.messages():
        walk.take(message.topic.removeprefix(PREFIX), message.payload)
        if len(walk.latest) < len(CAMERAS) or not walk.path:
            continue
        first_ns = first_ns or message.time_ns
        if (message.time_ns - first_ns) * 1e-9 * FRAMES_PER_S >= count:
            yield Moment(dict(walk.latest), list(walk.path))
            count += 1
        if count > seconds * FRAMES_PER_S:
            return


def draw(moment: Moment, whole: Path2d, bag: Bag) -> Pixels:
    """Returns one frame of the picture: the cameras and the path, side by side."""
    tiles = [
        _labelled(_fitted(decoded_image(bag.types[PREFIX + topic], payload)), label)
        for topic, label in CAMERAS.items()
        for payload in (moment.payloads[topic],)
    ]
    tiles.append(_labelled(_path_tile(moment.path, whole), "head_pose (from above)"))
    return np.hstack(tiles).astype(np.uint8)


def _path_tile(path: Path2d, whole: Path2d) -> Pixels:
    """Returns the path so far and, darker, the whole one; x points up and y to the left."""
    tile = np.full((TILE[1], TILE[0], 3), BACKGROUND, np.uint8)
    metres = np.array([(-y, -x) for x, y, _ in whole])
    low, high = metres.min(axis=0), metres.max(axis=0)
    scale = 0.8 * np.min(TILE / np.maximum(high - low, 0.1))
    points = (np.array(TILE) / 2 + scale * (metres - (low + high) / 2)).astype(np.int32)
    cv2.polylines(tile, [points], False, PATH_AHEAD, 2, cv2.LINE_AA)
    cv2.polylines(tile, [points[: len(path)]], False, PATH, 2, cv2.LINE_AA)
    here, yaw = points[len(path) - 1], path[-1][2]
    tip = here + (18 * np.array([-np.sin(yaw), -np.cos(yaw)])).astype(np.int32)
    cv2.arrowedLine(tile, here.tolist(), tip.tolist(), HEADING, 2, cv2.LINE_AA, 0, 0.4)
    return tile


def _yaw(q: Any) -> float:
    return float(np.arctan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)))


def _fitted(picture: NDArray[Any]) -> Pixels:
    """Returns the picture scaled to cover a tile, cut at its longer side."""
    width, height = TILE
    scale = max(width / picture.shape[1], height / picture.shape[0])
    size = (round(picture.shape[1] * scale), round(picture.shape[0] * scale))
    scaled = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    x, y = (size[0] - width) // 2, (size[1] - height) // 2
    return np.asarray(scaled[y : y + height, x : x + width], np.uint8)


def _labelled(tile: Pixels, label: str) -> Pixels:
    bar = np.full((LABEL_HEIGHT, tile.shape[1], 3), BACKGROUND, np.uint8)
    cv2.putText(bar, label, (6, 15), cv2.FONT_HERSHEY_SIMPLEX, 0.42, TEXT, 1, cv2.LINE_AA)
    return np.vstack([bar, tile]).astype(np.uint8)


def write_gif(frames: list[Pixels], file: Path) -> None:
    """Writes the frames with one palette, so that still pixels cost nothing."""
    pictures = [Image.fromarray(cv2.cvtColor(frame, cv2.COLOR_BGR2RGB)) for frame in frames]
    sample = Image.fromarray(np.vstack([np.asarray(it) for it in pictures[:: len(pictures) // 4]]))
    palette = sample.quantize(128, dither=Image.Dither.NONE)
    first, *rest = [it.quantize(palette=palette, dither=Image.Dither.NONE) for it in pictures]
    first.save(
        file,
        save_all=True,
        append_images=rest,
        duration=1000 // FRAMES_PER_S,
        loop=0,
        optimize=True,
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("recording", type=Path, help="a folder of ml2-receiver record")
    parser.add_argument("picture", type=Path, help="the GIF to write")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long it shows")
    arguments = parser.parse_args()
    bag = Bag(arguments.recording)
    shown = list(moments(bag, arguments.seconds))
    if not shown:
        print(f"{arguments.recording}: expected images of {', '.join(CAMERAS)}", file=sys.stderr)
        return 2
    write_gif([draw(moment, shown[-1].path, bag) for moment in shown], arguments.picture)
    size = arguments.picture.stat().st_size
    if size > MAX_BYTES:
        print(f"{arguments.picture} has {size} B, expected at most {MAX_BYTES}", file=sys.stderr)
        return 1
    print(f"{arguments.picture}: {len(shown)} frames, {size / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())

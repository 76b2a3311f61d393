"""Packs the present images, points, cameras and poses into a zip file."""

import io
import math
import time
import zipfile
from collections.abc import Collection, Mapping
from contextlib import suppress
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ml2_receiver.configuration.calibration import Calibration, calibration_yaml
from ml2_receiver.json_text import json_text
from ml2_receiver.printable import printable
from ml2_receiver.topics.stamps import header_stamp_ns

from ..bags.decoding import decoder
from ..images.pixels import pixels_of
from .cloud import CLOUD, Points, points_in_world
from .newest_image import Newest
from .scene import SCENE
from .state import image_streams, published_images
from .view import View

SNAPSHOT = "snapshot"
# Cameras may have been paused until now.
_PATIENCE_S = 5.0
_KEPT_S = 1.0
_POLL_S = 0.05
_MM_PER_M = 1000
_DEPTH, _COLOR = "depth", "color"


def snapshot_of(view: View, shown: Collection[str]) -> bytes:
    """Returns a zip file of what the source delivers at present; waits for it for 5 s at most.

    Args:
        shown: the streams that the browser shows; others are taken, too, but eye cameras.
    """
    wanted = (
        {*image_streams(with_eyes=False), *shown}
        & published_images(view.rows).keys()
        & set(view.streams)
    )
    watcher = object()
    view.watch(watcher, frozenset({*wanted, SCENE, CLOUD}))
    try:
        return _zip(view, _newest(view, sorted(wanted)))
    finally:
        view.watch(watcher, None)


def _newest(view: View, streams: Collection[str]) -> dict[str, Newest]:
    """Returns an image of each stream; waits for those whose lens and pose are not there yet.

    On a slow machine, the pose of an image comes after the next image. So one is kept for a while.
    """
    deadline_s = time.monotonic() + _PATIENCE_S
    found: dict[str, Newest] = {}
    kept_until_s = dict.fromkeys(streams, 0.0)
    missing = set(streams)
    while missing:
        for stream in list(missing):
            newest, now_s = view.images[stream].newest, time.monotonic()
            kept = found.get(stream)
            if kept is None or not kept[1] or now_s >= kept_until_s[stream]:
                found[stream], kept_until_s[stream] = newest, now_s + _KEPT_S
            for image in (newest, found[stream]):
                if _is_complete(view, stream, image):
                    found[stream] = image
                    missing.discard(stream)
                    break
        if time.monotonic() >= deadline_s:
            break
        time.sleep(_POLL_S)
    return found


def _is_complete(view: View, stream: str, image: Newest) -> bool:
    _, type, payload = image
    if not type or stream not in (_DEPTH, _COLOR):
        return bool(type)
    with suppress(ValueError):
        stamp_ns = header_stamp_ns(decoder(type)(payload).header)
        has_pose = view.scene.pose_at(stream, stamp_ns) is not None
        return has_pose and view.scene.lens(stream) is not None
    return True  # an invalid image gets no better


def _zip(view: View, newest: Mapping[str, Newest]) -> bytes:
    poses = view.scene.poses(view.now_s)
    index: dict[str, Any] = {"poses": {name: it.tolist() for name, it in poses.items()}}
    index["images"] = {}
    file = io.BytesIO()
    # PNG is compressed already.
    with zipfile.ZipFile(file, "w") as archive:
        for stream, image in newest.items():
            index["images"][stream] = _add(archive, view, stream, image)
        color, depth = (newest.get(it, (0, "", b"")) for it in (_COLOR, _DEPTH))
        if (points := points_in_world(view.scene, depth, color, math.inf)) is not None:
            archive.writestr("depth.ply", _ply(points))
        archive.writestr("poses.json", json_text(index, indent=2) + "\n")
    return file.getvalue()


def _add(archive: zipfile.ZipFile, view: View, stream: str, image: Newest) -> dict[str, Any]:
    """Adds the files of a stream; returns what poses.json says of its image."""
    _, type, payload = image
    if not type:
        return {"missing": f"no image came within {_PATIENCE_S:.0f} s"}
    frame = view.scene.frame_of(stream)
    if (info := view.scene.info(stream)) is not None:
        d, k, r, p = (tuple(map(float, it)) for it in (info.d, info.k, info.r, info.p))
        model = info.distortion_model
        camera = Calibration(info.width, info.height, model, d=d, k=k, r=r, p=p)
        archive.writestr(f"{stream}.yaml", calibration_yaml(stream, camera))
    try:
        message = decoder(type)(payload)
        archive.writestr(f"{stream}.png", _png(pixels_of(message), stream == _DEPTH))
    except ValueError as error:
        return {"missing": printable(str(error))}
    stamp_ns = header_stamp_ns(message.header)
    pose = view.scene.pose_at(stream, stamp_ns)
    return {"stamp_ns": stamp_ns, "frame": frame, "pose": None if pose is None else pose.tolist()}


def _png(pixels: NDArray[Any], is_distance: bool) -> bytes:
    """Returns a PNG; floats become 16 bits, distances in mm. What is invalid becomes 0."""
    if pixels.dtype == np.float32:
        scaled = np.nan_to_num(pixels * (_MM_PER_M if is_distance else 1), posinf=0, neginf=0)
        pixels = np.clip(np.rint(scaled), 0, np.iinfo(np.uint16).max).astype(np.uint16)
    is_encoded, png = cv2.imencode(".png", pixels, (cv2.IMWRITE_PNG_COMPRESSION, 1))
    if not is_encoded:
        raise ValueError("the image cannot be written as PNG")
    return png.tobytes()


def _ply(points: Points) -> bytes:
    places, colours = points
    names = ["x", "y", "z"]
    fields: list[Any] = [(name, "<f4") for name in names]
    head = [f"property float {name}" for name in names]
    if colours is not None:
        fields += [(name, "u1") for name in ("red", "green", "blue")]
        head += [f"property uchar {name}" for name in ("red", "green", "blue")]
    rows = np.empty(len(places), fields)
    for axis, name in enumerate(names):
        rows[name] = places[:, axis]
    if colours is not None:
        for axis, name in enumerate(("red", "green", "blue")):
            rows[name] = colours[:, axis]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(places)}", *head]
    return "\n".join([*lines, "end_header", ""]).encode() + rows.tobytes()

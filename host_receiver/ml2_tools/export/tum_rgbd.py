"""Converts a camera and the depth camera of a recording to a folder in the TUM RGB-D format.

Format: https://cvg.cit.tum.de/data/datasets/rgbd-dataset/file_formats
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ml2_receiver.private_files import make_private_folder
from ml2_receiver.topics.stamps import stamp_reader

from ..bags.bag_reader import BagMessage, BagReader
from ..bags.decoding import decoder
from ..errors import ExportError
from ..evaluation.sequence import Sequence, read_sequence
from ..evaluation.tum import write_tum
from ..geometry.camera import Camera
from ..geometry.lens import Lens, z_per_distance
from ..geometry.pose import Pose
from ..images.pixels import pixels_of
from ..images.rectification import rectify
from ..products.registration import register
from .png_files import PngFiles
from .rig import add_rising

_LEVELS_PER_M = 5000
_MOST_LEVEL = 65535
# The headset's fastest camera has 60 Hz, the slowest depth 5 Hz.
_MOST_APART_NS = 100_000_000
_SECOND_NS = 1_000_000_000


def write_tum_rgbd(
    folder: Path,
    bag: Path,
    reader: BagReader,
    camera: str,
    on_bytes: Callable[[int], None] = lambda _: None,
) -> tuple[int, int]:
    """Writes the camera's images without distortion, and depth as that camera would see it.

    A depth image has the name of the nearest image of the camera, at whose pose it is registered:
    both are of one stamp. groundtruth.txt has the headset's own poses of the optical frame.

    Args:
        folder: must not exist yet.
        bag: the recording, which `reader` reads.
        on_bytes: is called with each payload's length.

    Returns:
        The numbers of images and of depth images.

    Raises:
        ExportError: the folder exists already or cannot be written, or a message is invalid.
        EvaluationError: images, camera_info or poses of a camera are missing.
        RecordingError: the recording is broken.
    """
    if folder.exists():
        raise ExportError(f"{folder} exists already: choose another folder")
    images, depths = (read_sequence(bag, it, reader.prefix) for it in (camera, "depth"))
    stream = reader.config.streams.get("depth")
    is_radial = bool(((stream and stream.values) or {}).get("radial", False))
    data = _Data(folder, images, depths, _Registration(images, depths, is_radial))
    try:
        for it in (folder, *(folder / name for name in data.stamps_ns)):
            make_private_folder(it)
        with PngFiles() as files:
            for message in reader.messages():
                try:
                    data.take(message, files)
                except ValueError as error:
                    raise ExportError(f"{message.topic}: {error}") from error
                on_bytes(len(message.payload))
        data.write_lists()
    except OSError as error:
        raise ExportError(f"{folder} cannot be written: {error.strerror}") from error
    return len(data.stamps_ns["rgb"]), len(data.stamps_ns["depth"])


class _Data:
    """The files of a folder.

    Attributes:
        stamps_ns: those in the names of the images so far, by folder.
    """

    def __init__(
        self, folder: Path, images: Sequence, depths: Sequence, registration: _Registration
    ) -> None:
        self._folder, self._images, self._registration = folder, images, registration
        self._sequences = {images.topic: images, depths.topic: depths}
        self.stamps_ns: dict[str, list[int]] = {"rgb": [], "depth": []}

    def take(self, message: BagMessage, files: PngFiles) -> None:
        """Writes an image of either camera, and passes over all else.

        Raises:
            ValueError: the message is invalid, or its stamp does not rise.
        """
        sequence = self._sequences.get(message.topic)
        if sequence is None:
            return
        stamp_ns = stamp_reader(sequence.type)(message.payload)
        is_image = sequence is self._images
        named_ns = stamp_ns if is_image else self._registration.partners.get(stamp_ns)
        if named_ns is None:
            return
        name = "rgb" if is_image else "depth"
        add_rising(self.stamps_ns[name], named_ns)

        def image() -> NDArray[Any]:
            pixels = pixels_of(decoder(sequence.type)(message.payload))
            if is_image:
                return rectify(pixels, self._images.camera)
            return self._registration.image(pixels, stamp_ns)

        files.write(self._folder / name / f"{_seconds(named_ns)}.png", message.topic, image)

    def write_lists(self) -> None:
        """Writes the lists of images, of their pairs, and of the camera's poses."""
        at = {name: [_seconds(it) for it in stamps] for name, stamps in self.stamps_ns.items()}
        for name, stamps in at.items():
            self._write(f"{name}.txt", (f"{it} {name}/{it}.png" for it in stamps))
        pairs = (f"{it} rgb/{it}.png {it} depth/{it}.png" for it in at["depth"])
        self._write("associations.txt", pairs)
        taken = set(self.stamps_ns["rgb"])
        poses = [it for it in self._images.reference if it[0] in taken]
        write_tum(self._folder / "groundtruth.txt", poses)

    def _write(self, name: str, lines: Iterable[str]) -> None:
        (self._folder / name).write_text("".join(f"{it}\n" for it in lines))


class _Registration:
    """Depth as another camera sees it without distortion.

    Attributes:
        partners: the stamp of the nearest image by stamp of a depth image. No image has two.
    """

    def __init__(self, images: Sequence, depths: Sequence, is_radial: bool) -> None:
        self._target = pinhole(images.camera)
        self._lens, self._is_radial = depths.camera.lens, is_radial
        self._to_target = np.eye(4)
        self._to_target[:3, :3] = np.array(images.camera.rotation).reshape(3, 3)
        self._poses, self._depth_poses = dict(images.reference), dict(depths.reference)
        known = np.array(sorted(set(images.stamps_ns) & self._poses.keys()))
        nearest: dict[int, int] = {}
        for stamp_ns in set(depths.stamps_ns) & self._depth_poses.keys() if known.size else ():
            partner = int(known[np.argmin(np.abs(known - stamp_ns))])
            before_ns = nearest.get(partner, partner + _MOST_APART_NS)
            if abs(stamp_ns - partner) <= abs(before_ns - partner):
                nearest[partner] = stamp_ns
        self.partners = {stamp_ns: partner for partner, stamp_ns in nearest.items()}

    def image(self, pixels: NDArray[Any], stamp_ns: int) -> NDArray[np.uint16]:
        """Returns the levels of the TUM format: 5000 for a metre, 0 where depth is not known."""
        if pixels.shape != (self._lens.height, self._lens.width):
            raise ValueError(
                f"expected {self._lens.height, self._lens.width}, found {pixels.shape}"
            )
        z = pixels * z_per_distance(self._lens) if self._is_radial else pixels
        target: Pose = np.linalg.inv(self._poses[self.partners[stamp_ns]])
        between = self._to_target @ target @ self._depth_poses[stamp_ns]
        levels = _LEVELS_PER_M * register(z, self._lens, between, self._target)
        return np.where(levels < _MOST_LEVEL, np.rint(levels), 0).astype(np.uint16)


def pinhole(camera: Camera) -> Lens:
    """Returns the lens of the camera's image without distortion."""
    fx, _, cx, _, fy, cy, *_ = camera.matrix
    return Lens(camera.lens.width, camera.lens.height, fx, fy, cx, cy, "plumb_bob", (0.0,) * 5)


def _seconds(stamp_ns: int) -> str:
    seconds, nanos = divmod(stamp_ns, _SECOND_NS)
    return f"{seconds}.{nanos:09d}"

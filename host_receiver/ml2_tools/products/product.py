"""The products, each with its inputs and its computation."""

import copy
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ml2_receiver.table.reader import load_table

from ..geometry.camera import camera_of
from ..geometry.lens import Floats, Lens, z_per_distance
from ..geometry.pose import Pose
from ..images.image_topic import image_topics
from ..images.pixels import encoding_of, is_compressed, pixels_of
from ..images.rectification import rectify
from ..monitoring.losses import Losses
from .captures import Captures
from .messages import cloud_message, image_message
from .points import colours_of, points_of
from .registration import register

type Capture = Mapping[str, Any]

# While depth runs, cameras run at 15 Hz or more, so that a capture is at most 33 ms from a depth
# image.
_MOST_APART_NS = 100_000_000
_REMEMBERED = 8


@dataclass
class Shared:
    """The state that all products share.

    `is_radial` is True if depth is the distance from the camera, False if it is z. It is None until
    the headset's settings are known; until then no product of depth is made.
    """

    is_radial: bool | None = None
    losses: Losses = field(default_factory=Losses)
    _decoded: dict[str, tuple[Any, NDArray[Any]]] = field(default_factory=dict)

    def pixels(self, camera: str, message: Any) -> NDArray[Any]:
        """Returns the pixels of a camera's image, as pixels_of(); nobody may change them.

        A message that several products need is decoded once.

        Raises:
            ValueError: the image is invalid.
        """
        if camera not in self._decoded or self._decoded[camera][0] is not message:
            self._decoded[camera] = message, pixels_of(message)
        return self._decoded[camera][1]

    def depth(self, capture: Capture, lens: Lens) -> Floats:
        """Returns z of a depth capture, height x width.

        Raises:
            ValueError: the settings are not known yet, or the image is invalid.
        """
        if self.is_radial is None:
            raise ValueError("whether depth is radial is not known yet: nothing came on config")
        z: Floats = self.pixels("depth", capture["image"])
        if not self.is_radial:
            return z
        if z.shape != (lens.height, lens.width):
            raise ValueError(f"expected depth of {lens.height, lens.width}, found {z.shape}")
        return z * z_per_distance(lens)


class Product(ABC):
    """A computation that makes messages when a capture is complete. Not thread-safe.

    Attributes:
        types: the message types by topic, relative to the prefix.
        inputs: the needed parts of captures by camera.
    """

    types: Mapping[str, str]

    def __init__(self, shared: Shared, inputs: Mapping[str, tuple[str, ...]]) -> None:
        self._shared = shared
        self.use(inputs)

    def use(self, inputs: Mapping[str, tuple[str, ...]]) -> None:
        """Changes the inputs and forgets incomplete captures."""
        self.inputs = inputs
        self._captures = {
            camera: Captures(camera, parts, self._shared.losses) for camera, parts in inputs.items()
        }

    def add(self, camera: str, part: str, stamp_ns: int, value: Any) -> Mapping[str, Any]:
        """Takes a part; returns the messages by topic if it completes a capture.

        Raises:
            ValueError: a message is invalid or does not fit its camera.
        """
        if part not in self.inputs.get(camera, ()):
            return {}
        capture = self._captures[camera].add(part, stamp_ns, value)
        return {} if capture is None else self.make(camera, stamp_ns, capture)

    @abstractmethod
    def make(self, camera: str, stamp_ns: int, capture: Capture) -> Mapping[str, Any]:
        """Returns the messages of a complete capture by topic."""


class Rectified(Product):
    """<world camera>/image_rect, with the exact lens in the metadata.

    image_proc can rectify the other cameras, because their camera_info describes the lens exactly.
    """

    def __init__(self, shared: Shared, camera: str) -> None:
        super().__init__(shared, {camera: ("image", "camera_info", "metadata")})
        self.types = {f"{camera}/image_rect": "sensor_msgs/msg/Image"}

    def make(self, camera: str, stamp_ns: int, capture: Capture) -> Mapping[str, Any]:
        image = capture["image"]
        model = camera_of(capture["camera_info"], capture["metadata"])
        pixels = rectify(self._shared.pixels(camera, image), model)
        return {f"{camera}/image_rect": image_message(image.header, encoding_of(pixels), pixels)}


class Raw(Product):
    """The raw image topic of a camera whose headset publishes the compressed one.

    Attributes:
        compressed: the name of the compressed topic, relative to the prefix.
    """

    def __init__(self, shared: Shared, camera: str) -> None:
        super().__init__(shared, {camera: ("image",)})
        raw, compressed, *_ = image_topics(camera)
        self.types = {raw.name: raw.type}
        self.compressed = compressed.name

    def make(self, camera: str, stamp_ns: int, capture: Capture) -> Mapping[str, Any]:
        image = capture["image"]
        # A headset that has just changed the format publishes the raw image itself.
        if not is_compressed(image):
            return {}
        pixels = self._shared.pixels(camera, image)
        (topic,) = self.types
        return {topic: image_message(image.header, encoding_of(pixels), pixels)}


class _WithOther(Product):
    """A product of a depth capture and the other camera's capture that is nearest in time."""

    def __init__(self, shared: Shared, inputs: Mapping[str, tuple[str, ...]]) -> None:
        super().__init__(shared, inputs)
        self._others: deque[tuple[int, Capture]] = deque(maxlen=_REMEMBERED)

    def make(self, camera: str, stamp_ns: int, capture: Capture) -> Mapping[str, Any]:
        if camera != "depth":
            self._others.append((stamp_ns, capture))
            return {}
        return self.of_depth(stamp_ns, capture)

    @abstractmethod
    def of_depth(self, stamp_ns: int, capture: Capture) -> Mapping[str, Any]:
        """Returns the messages of a depth capture by topic."""

    def nearest(self, stamp_ns: int) -> tuple[int, Capture] | None:
        """Returns stamp and capture of the nearest other one within 0.1 s, or None."""
        near = min(self._others, key=lambda other: abs(other[0] - stamp_ns), default=None)
        return near if near is not None and abs(near[0] - stamp_ns) <= _MOST_APART_NS else None


class Points(_WithOther):
    """depth/points, with colours after colour(True), for which it needs transforms."""

    types = {"depth/points": "sensor_msgs/msg/PointCloud2"}  # noqa: RUF012
    _PLAIN = {"depth": ("image", "camera_info")}  # noqa: RUF012
    _COLOURED = {  # noqa: RUF012
        "depth": ("image", "camera_info", "transform"),
        "color": ("image", "camera_info", "transform"),
    }

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared, self._PLAIN)

    def colour(self, is_coloured: bool) -> None:
        """Switches the colours on or off."""
        wanted = self._COLOURED if is_coloured else self._PLAIN
        if self.inputs is not wanted:
            self._others.clear()
            self.use(wanted)

    def of_depth(self, stamp_ns: int, capture: Capture) -> Mapping[str, Any]:
        lens = camera_of(capture["camera_info"]).lens
        points = points_of(self._shared.depth(capture, lens), lens)
        rgb = None
        near = self.nearest(stamp_ns)
        if near is not None:
            _, color = near
            bgr = self._shared.pixels("color", color["image"])
            between = _between(capture["transform"], color["transform"])
            rgb = colours_of(points, between, camera_of(color["camera_info"]).lens, bgr)
        elif self.inputs is self._COLOURED:
            self._shared.losses.add("depth/points without colours: no image of color within 0.1 s")
        return {"depth/points": cloud_message(capture["image"].header, points, rgb)}


class Registered(_WithOther):
    """aligned_depth_to_<camera>/image_raw and camera_info, at stamps of that camera's images."""

    def __init__(self, shared: Shared, camera: str, parts: tuple[str, ...]) -> None:
        inputs = {"depth": ("image", "camera_info", "transform"), camera: parts}
        super().__init__(shared, inputs)
        self._topic, self._last_ns = f"aligned_depth_to_{camera}", 0
        self.types = {
            f"{self._topic}/image_raw": "sensor_msgs/msg/Image",
            f"{self._topic}/camera_info": "sensor_msgs/msg/CameraInfo",
        }

    def of_depth(self, stamp_ns: int, capture: Capture) -> Mapping[str, Any]:
        near = self.nearest(stamp_ns)
        if near is None:
            self._shared.losses.add(f"{self._topic}: no image of the camera within 0.1 s")
            return {}
        target_ns, other = near
        if target_ns == self._last_ns:
            self._shared.losses.add(f"{self._topic}: the image has a depth image already")
            return {}
        self._last_ns = target_ns
        info = other["camera_info"]
        lens, target = (
            camera_of(capture["camera_info"]).lens,
            camera_of(info, other.get("metadata")),
        )
        between = _between(capture["transform"], other["transform"])
        z = register(self._shared.depth(capture, lens), lens, between, target.lens)
        return {
            f"{self._topic}/image_raw": image_message(info.header, "32FC1", z),
            f"{self._topic}/camera_info": copy.copy(info),
        }


def _between(source: Pose, target: Pose) -> Pose:
    """Returns the transform from one capture's optical frame to another's; both are world poses."""
    between: Pose = np.linalg.inv(target) @ source
    return between


def _has_raw_and_compressed(camera: str) -> bool:
    types = {it.type for it in image_topics(camera)}
    return {"sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"} <= types


def all_products(shared: Shared) -> list[Product]:
    """Returns all products."""
    compressible = [it for it in load_table().streams if _has_raw_and_compressed(it)]
    worlds = ("world_left", "world_center", "world_right")
    exact = ("camera_info", "metadata", "transform")
    return [
        Points(shared),
        *(Rectified(shared, each) for each in worlds),
        Registered(shared, "color", ("camera_info", "transform")),
        *(Registered(shared, each, exact) for each in worlds),
        *(Raw(shared, each) for each in compressible),
    ]

"""Images and poses of one camera in a recording."""

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ml2_receiver.table.reader import load_table
from ml2_receiver.topics.plain_messages import decode_string
from ml2_receiver.topics.stamps import stamp_reader

from ..bags.bag_reader import Bag, BagReader
from ..bags.decoding import decoder
from ..errors import EvaluationError
from ..geometry.camera import Camera, camera_of, metadata_stamp_ns
from ..geometry.transform_tree import Tree
from ..images.image_topic import image_topic
from ..images.pixels import grey_of
from .trajectory import Images, Trajectory


@dataclass(frozen=True)
class Sequence:
    """One camera's images and poses in a recording.

    Attributes:
        topic, type: the name and the message type of the image topic.
        camera: the camera, from its first camera_info and the metadata of the same capture.
        images_sent: the number of captures by the frame numbers in the metadata, from the first to
            the last; without frame numbers, the number of images that arrived.
        stamps_ns: the stamps of the images that arrived.
        reference: the poses of the optical frame in the world by /tf; stamps rise.
        left_out: what the recording has and was not read, in words.
        apart: where it may be another recording, in words.
    """

    bag: Path
    topic: str
    type: str
    camera: Camera
    images_sent: int
    stamps_ns: list[int]
    reference: Trajectory
    left_out: Iterable[str] = ()
    apart: Iterable[str] = ()

    def images(self) -> Images:
        """Reads the images from the recording, one at a time.

        Raises:
            RecordingError: the recording is broken.
            EvaluationError: a message is no image, or stamps do not rise.
        """
        messages = (it for it in Bag(self.bag).messages() if it.topic == self.topic)
        where = f"{self.bag}: {self.topic}"
        return grey_images((it.payload for it in messages), self.type, where)


def grey_images(payloads: Iterable[bytes], type: str, where: str) -> Images:
    """Decodes images lazily.

    Args:
        where: the source of the images, for error messages.

    Raises:
        EvaluationError: a message is no image, or stamps do not rise.
    """
    decode, read_stamp, last_ns = decoder(type), stamp_reader(type), -1
    for payload in payloads:
        try:
            pixels, stamp_ns = grey_of(decode(payload)), read_stamp(payload)
            if stamp_ns <= last_ns:
                raise ValueError(f"stamp {stamp_ns} comes after {last_ns}")
        except ValueError as error:
            raise EvaluationError(f"{where}: {error}") from error
        last_ns = stamp_ns
        yield stamp_ns, pixels.astype(np.uint8, copy=False)


def read_sequence(bag: Path, camera: str, headset: str | None = None) -> Sequence:
    """Reads one camera of a recording; Sequence.images() reads the images on each call.

    Args:
        camera: the camera's stream, such as world_center.
        headset: whose camera, by the names that BagReader takes; None if there is only one.

    Raises:
        RecordingError: the file is not a recording of this receiver.
        EvaluationError: images, camera_info or poses of the camera are missing, or an image has no
            stamp.
    """
    reader = BagReader(bag, headset)
    parts = Parts(reader.prefix, camera, reader.types.get)
    for message in reader.messages():
        try:
            parts.take(message.topic, message.payload)
        except ValueError as error:
            raise EvaluationError(f"{bag}: {message.topic}: {error}") from error
    return replace(parts.sequence(bag), left_out=reader.left_out, apart=reader.apart)


class Parts:
    """Collects the parts of a Sequence message by message; keeps only the stamps of images.

    Args:
        prefix: the prefix of the headset's topics.
        camera: the camera's stream, such as world_center.
        exists: returns a true value for the absolute name of a topic that exists.

    Attributes:
        types: the message types of the needed topics, by absolute name.
        image: the name of the image topic.
    """

    def __init__(self, prefix: str, camera: str, exists: Callable[[str], object]) -> None:
        topics = {topic.role: topic for topic in load_table().streams[camera].topics}
        topics["image"] = image_topic(camera, prefix, exists)
        self._names = {role: topic.full_name(prefix) for role, topic in topics.items()}
        self.types = {topic.full_name(prefix): topic.type for topic in topics.values()}
        self.types |= dict.fromkeys(_TRANSFORMS, _TF)
        self.image = self._names["image"]
        self._camera = camera
        self._read_stamp = stamp_reader(self.types[self.image])
        self._stamps_ns: list[int] = []
        self._payloads: dict[str, list[bytes]] = {name: [] for name in self.types}

    @property
    def images_taken(self) -> int:
        """The number of images so far."""
        return len(self._stamps_ns)

    def take(self, topic: str, payload: bytes) -> None:
        """Adds a message of any topic.

        Raises:
            ValueError: it is an image without a stamp.
        """
        if topic == self.image:
            self._stamps_ns.append(self._read_stamp(payload))
        elif topic in self._payloads:
            self._payloads[topic].append(payload)

    def camera(self) -> Camera | None:
        """Returns the camera of the first camera_info, or None until it and metadata have arrived.

        Raises:
            EvaluationError: camera_info or metadata are invalid.
        """
        infos, texts = (self._payloads[self._names[it]] for it in ("camera_info", "metadata"))
        if not infos or not texts:
            return None
        try:
            return _camera(infos[0], [decode_string(it).decode() for it in texts])[0]
        except ValueError as error:
            raise EvaluationError(f"{self._camera}: {error}") from error

    def sequence(self, bag: Path) -> Sequence:
        """Returns the sequence of all messages so far.

        Raises:
            EvaluationError: images, camera_info or poses of the camera are missing.
        """
        payloads, camera = self._payloads, self._camera
        infos = payloads[self._names["camera_info"]]
        if not self._stamps_ns or not infos:
            raise EvaluationError(f"{bag} has no images with camera_info of {camera}")
        try:
            texts = [decode_string(it).decode() for it in payloads[self._names["metadata"]]]
            lens, frame = _camera(infos[0], texts)
            reference = _poses(payloads, camera, frame)
            captures = _captures(texts) or len(self._stamps_ns)
        except ValueError as error:
            raise EvaluationError(f"{bag}: {camera}: {error}") from error
        if not reference:
            raise EvaluationError(f"{bag} has no transform of {frame} on /tf")
        type = self.types[self.image]
        return Sequence(bag, self.image, type, lens, captures, self._stamps_ns, reference)


_TRANSFORMS = ("/tf", "/tf_static")
_INFO, _TF = "sensor_msgs/msg/CameraInfo", "tf2_msgs/msg/TFMessage"


def _camera(info_payload: bytes, metadata: list[str]) -> tuple[Camera, str]:
    """Returns the camera and the name of its optical frame."""
    read_stamp = stamp_reader(_INFO)
    same = (it for it in metadata if metadata_stamp_ns(it) == read_stamp(info_payload))
    info = decoder(_INFO)(info_payload)
    return camera_of(info, next(same, None)), str(info.header.frame_id)


def _poses(payloads: dict[str, list[bytes]], camera: str, frame: str) -> Trajectory:
    tree = Tree.of({frame: camera})
    for payload in payloads["/tf_static"]:
        tree.stand(decoder(_TF)(payload))
    messages = (decoder(_TF)(payload) for payload in payloads["/tf"])
    return sorted({at: pose for it in messages for _, at, pose in tree.poses(it)}.items())


def _captures(metadata: list[str]) -> int:
    """Returns the number of captures by frame numbers, with lost ones; 0 without frame numbers."""
    objects = [found for it in metadata if isinstance(found := json.loads(it), dict)]
    counted = [number for it in objects if isinstance(number := it.get("frame_number"), int)]
    return max(counted) - min(counted) + 1 if counted else 0

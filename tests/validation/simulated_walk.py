"""Runs a walk with the simulated headset, and records it from a ROS 2 subscriber."""

import shutil
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml

from bags import write_bag
from ml2_receiver.topics.plain_messages import encode_string
from ml2_receiver.topics.stamps import stamp_reader
from ml2_tools.evaluation.tum import write_tum
from processes import PREFIX, ROOT, Received, receive
from simulated_truth import SimulatedTruth
from transforms import moving
from true_walk import TrueWalk, camera_in_head
from walks import REST_S, Walk

# The simulation begins within a second of the first image.
_SPARE_S = 1.5
_IMAGES_HZ = 30
# Stamps differ by some microseconds from the grid of captures, so windows extend by half a period.
_HALF_NS = 10**9 // _IMAGES_HZ // 2
_TRIES = 5
# Transforms are kept for this time before the first image and after the last.
_MARGIN_NS = 100_000_000
_CONFIG = '{"headset": "simulated", "session": "validation", "streams": {}}'


@dataclass(frozen=True)
class Walked:
    """The files of one walk.

    Attributes:
        bag: the recording from the walk's first image to its last.
        truth: a TUM file of the camera's true poses.
        images_sent: the number of images that the headset sent of that time.
        walked: the number of runs until this machine was fast enough to fetch the captures.
    """

    bag: Path
    truth: Path
    images_sent: int
    walked: int = 1


def stream(walk: Walk, folder: Path, headset_options: Sequence[str] = (), late: int = 0) -> Walked:
    """Runs headset, receiver and an independent subscriber; repeats if the simulation fell behind.

    Deletes `folder` first.

    Args:
        headset_options: more options of ml2-headset.
        late: the number of captures that the headset may fetch too late.

    Raises:
        RuntimeError: a message was lost that nobody counted, this machine's clock was set, or it
            was too busy each time.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory(dir=folder.parent, prefix="frame_cache") as cache:
        for walked in range(1, _TRIES + 1):
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            try:
                walk_sent = _streamed(walk, folder, cache, headset_options, late)
                return replace(walk_sent, walked=walked)
            except FellBehindError as error:
                print(f"{walk.name}: {error}", file=sys.stderr, flush=True)
    raise RuntimeError(f"{walk.name}: this machine is too busy to simulate a headset")


class FellBehindError(Exception):
    """This machine was too busy: the headset fetched an image too late, or dropped messages."""


def _streamed(
    walk: Walk, folder: Path, cache: str, headset_options: Sequence[str], late: int
) -> Walked:
    simulation = SimulatedTruth.now()
    mounting = camera_in_head(simulation, walk.camera)
    walk = walk.scaled(mounting)
    (folder / "walk.tum").write_text("".join(walk.tum()))
    (folder / "config.yaml").write_text(_config(walk.camera))
    simulate = ["--simulate", f"trajectory={folder / 'walk.tum'}", "--simulate", f"cache={cache}"]
    simulate += headset_options
    options = ["--duration", str(REST_S + walk.duration_s + _SPARE_S), *simulate]
    received = receive(folder / "config.yaml", options, folder)
    check_nothing_is_lost(received)
    if simulation.clock_was_set():
        raise RuntimeError("this machine's clock was set: the true poses are unknown")
    if not received.messages(f"{walk.camera}/camera_info"):
        raise FellBehindError("the walk ended before the simulation had drawn its images")
    truth = TrueWalk.found(received, walk, mounting, simulation)
    # The grid of captures and the walk both start at a whole second.
    captures = int(walk.duration_s * _IMAGES_HZ + 1e-6) + 1
    window_ns = truth.start_ns - _HALF_NS, truth.end_ns + _HALF_NS
    images = _images(received, walk.camera, *window_ns)
    images_sent = len(images)
    if not captures - late <= images_sent <= captures:
        raise FellBehindError(f"{captures - images_sent} of {captures} captures came too late")
    poses, frame = moving(received), f"{walk.camera}_optical_frame"
    if without_pose := [at for at in images if (frame, at) not in poses]:
        raise FellBehindError(f"the head's poses of {len(without_pose)} captures came too late")
    record(received, folder / "bag", *window_ns)
    write_tum(folder / "truth.tum", truth.trajectory(received))
    return Walked(folder / "bag", folder / "truth.tum", images_sent)


def record(received: Received, bag: Path, start_ns: int, end_ns: int) -> None:
    """Writes the messages with stamps from `start_ns` to `end_ns`, and some more transforms."""
    config = f"{PREFIX}/config"
    messages = [(config, 0, encode_string(_CONFIG))]
    for topic, (type, payloads) in received.topics.items():
        read_stamp = stamp_reader(type)
        margin_ns = _MARGIN_NS if topic == "/tf" else 0
        arrivals_ns = (round(at_s * 1e9) for at_s in received.arrivals_s[topic])
        messages += [
            (topic, at_ns, payload)
            for at_ns, payload in zip(arrivals_ns, payloads, strict=True)
            if start_ns - margin_ns <= read_stamp(payload) <= end_ns + margin_ns
        ]
    types = {topic: type for topic, (type, _) in received.topics.items()}
    messages.sort(key=lambda it: it[1])
    write_bag(bag, types | {config: "std_msgs/msg/String"}, messages)


def _config(camera: str) -> str:
    """Returns the packaged configuration with this camera alone, and with raw images."""
    tree = yaml.safe_load((ROOT / "config" / "config.yaml").read_text())
    (node,) = tree.values()
    node["ros__parameters"][camera]["format"] = "Grayscale"
    for name, section in node["ros__parameters"].items():
        if "enabled" in section:
            section["enabled"] = name == camera
    return str(yaml.safe_dump(tree))


def check_nothing_is_lost(received: Received) -> None:
    """Raises what stream() says or repeats for, but if captures were late, which it counts."""
    for topic, seen in received.snapshot["topics"].items():
        counters = received.counters(topic)
        dropped = {it: int(n) for it, n in counters.items() if it.startswith("dropped.") and int(n)}
        sent = int(counters["produced"]) - sum(dropped.values())
        if seen["count"] != sent:
            raise RuntimeError(f"{topic}: {seen['count']} of {sent} messages arrived")
        if dropped.keys() - {"dropped.source_late"}:
            raise FellBehindError(f"{topic}: {dropped}")


def _images(received: Received, camera: str, start_ns: int, end_ns: int) -> list[int]:
    """Returns the stamps of images from `start_ns` to `end_ns`."""
    type, payloads = received.topics[f"{PREFIX}/{camera}/image_raw"]
    return [at for at in map(stamp_reader(type), payloads) if start_ns <= at <= end_ns]

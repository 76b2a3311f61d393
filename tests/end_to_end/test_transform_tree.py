"""The transform tree during a loss of head tracking, and for late subscribers."""

from __future__ import annotations

import contextlib
import itertools
import json
import subprocess
from pathlib import Path

from capture_stamps import stamp_ns
from processes import PREFIX, Received, headset_command, lines, receive, result, subscribing
from simulation import CAMERAS, five_cameras, image_topic, one_camera
from transforms import mounted, moving, stable_since_ns
from waiting_receiver import WaitingReceiver, waiting_receiver

CAMERA = "world_left"


def received_with(folder: Path, config: str, *options: str) -> Received:
    file = folder / "config.yaml"
    file.write_text(config)
    return receive(file, ["--duration", "3", *options], folder)


def test_while_the_head_is_not_tracked_there_are_images_but_no_transforms(tmp_path: Path) -> None:
    received = received_with(tmp_path, five_cameras(), "--simulate", "fault.head.tracking=2")
    for camera in CAMERAS:
        assert len(stamps_of(received, camera)) > 20
    assert received.messages("/tf") == []


def test_transforms_end_and_begin_with_the_tracking_and_a_new_world_is_announced(
    tmp_path: Path,
) -> None:
    received = received_with(
        tmp_path,
        one_camera(),
        *("--simulate", "fault.head.tracking=2@0.8"),
        *("--simulate", "fault.head.tracking=0@2"),
        *("--simulate", "fault.head.new_session=1@2.5"),
    )
    heads = sorted(at for child, at in moving(received) if child == "head_frame")
    gap_ns, begin = max((b - a, a) for a, b in itertools.pairwise(heads))
    assert 0.8e9 < gap_ns < 1.6e9
    in_between = [at for at in stamps_of(received, CAMERA) if begin < at < begin + gap_ns]
    assert len(in_between) > 5
    log = (tmp_path / "receiver.log").read_text()
    assert log.index("head tracking is lost") < log.index("head tracking is recovered")
    assert "head tracking has restarted" in log


def test_a_late_subscriber_gets_the_mountings(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(one_camera(tf={"layout": "rig"}))
    late_folder = tmp_path / "late"
    late_folder.mkdir()
    with contextlib.ExitStack() as stack:
        waiting = stack.enter_context(waiting_receiver(config, tmp_path))
        with waiting.started("headset", headset_command(waiting.address)):
            await_stable_mounting(waiting)
            subscriber = stack.enter_context(subscribing(waiting.environment, late_folder))
            await_mountings_and_an_image(subscriber)
        late = result(subscriber, late_folder)
        received = waiting.result()
    stable_ns = stable_since_ns(received)
    assert stable_ns is not None
    assert min(stamps_of(late, CAMERA)) > stable_ns
    assert mounted(late).keys() == mounted(received).keys()
    assert f"{CAMERA}_optical_frame" in mounted(late)


def await_stable_mounting(waiting: WaitingReceiver) -> None:
    log = waiting.folder / "receiver.log"
    for _ in lines(waiting.subscriber):
        if f"the mounting of {CAMERA} is stable" in log.read_text():
            return
    raise AssertionError("the subscriber ended before the mounting was stable")


def await_mountings_and_an_image(subscriber: subprocess.Popen[str]) -> None:
    awaited = ["/tf_static", f"{PREFIX}/{image_topic(CAMERA)}"]
    for line in lines(subscriber):
        topics = json.loads(line)["topics"]
        if all(topics[topic]["count"] for topic in awaited):
            return
    raise AssertionError(f"the subscriber ended before {', '.join(awaited)} arrived")


def stamps_of(received: Received, camera: str) -> list[int]:
    return [stamp_ns(it) for it in received.messages(image_topic(camera))]

"""The transform tree during a loss of head tracking, and for late subscribers."""

from __future__ import annotations

import contextlib
import itertools
from pathlib import Path

from capture_stamps import stamp_ns
from counters import await_more, await_snapshot, have_arrived
from processes import Received, headset_command, receive, result, subscribing
from simulation import (
    CAMERAS,
    SIMULATE,
    STILL,
    five_cameras,
    image_topic,
    one_camera,
    simulate,
)
from transforms import mounted, moving, stable_since_ns
from waiting_receiver import WaitingReceiver, waiting_receiver

CAMERA = "world_left"
LOST = "fault.head.tracking=2"


def test_while_the_head_is_not_tracked_there_are_images_but_no_transforms(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(five_cameras())
    least = have_arrived({image_topic(camera): 21 for camera in CAMERAS})
    received = receive(config, [*STILL, "--simulate", LOST], tmp_path, is_enough=least)
    for camera in CAMERAS:
        assert len(stamps_of(received, camera)) > 20
    assert received.messages("/tf") == []


def test_transforms_end_and_begin_with_the_tracking_and_a_new_world_is_announced(
    tmp_path: Path,
) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(one_camera())
    with (
        waiting_receiver(config, tmp_path) as waiting,
        waiting.started("headset", headset_command(waiting.address, *STILL, *SIMULATE)) as headset,
    ):
        await_more(waiting.subscriber, "/tf")
        simulate(headset, LOST)
        await_log(waiting, "head tracking is lost")
        await_more(waiting.subscriber, image_topic(CAMERA), 6)
        simulate(headset, "fault.head.tracking=0")
        await_log(waiting, "head tracking is recovered")
        simulate(headset, "fault.head.new_session=1")
        await_log(waiting, "head tracking has restarted")
        await_more(waiting.subscriber, "/tf")
        headset.terminate()
        received = waiting.result()
    heads = sorted(at for child, at in moving(received) if child == "head_frame")
    images = stamps_of(received, CAMERA)
    assert any(
        sum(before < at < after for at in images) > 5 for before, after in itertools.pairwise(heads)
    )


def test_a_late_subscriber_gets_the_mountings(tmp_path: Path) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(one_camera(tf={"layout": "rig"}))
    late_folder = tmp_path / "late"
    late_folder.mkdir()
    with contextlib.ExitStack() as stack:
        waiting = stack.enter_context(waiting_receiver(config, tmp_path))
        with waiting.started("headset", headset_command(waiting.address, *STILL)):
            await_log(waiting, f"the mounting of {CAMERA} is stable")
            subscriber = stack.enter_context(subscribing(waiting.environment, late_folder))
            await_snapshot(subscriber, have_arrived({"/tf_static": 1, image_topic(CAMERA): 1}))
        late = result(subscriber, late_folder)
        received = waiting.result()
    stable_ns = stable_since_ns(received)
    assert stable_ns is not None
    assert min(stamps_of(late, CAMERA)) > stable_ns
    assert mounted(late).keys() == mounted(received).keys()
    assert f"{CAMERA}_optical_frame" in mounted(late)


def await_log(waiting: WaitingReceiver, words: str) -> None:
    """Waits until the receiver has said it."""
    log = waiting.folder / "receiver.log"
    waiting.await_snapshot(lambda _: words in log.read_text())


def stamps_of(received: Received, camera: str) -> list[int]:
    return [stamp_ns(it) for it in received.messages(image_topic(camera))]

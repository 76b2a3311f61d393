"""Every check of a recording, on one that is sound and on that one damaged in each way."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

import bag_scene
from command_line import refusal
from ml2_receiver.cli import main
from ml2_receiver.recording.message_definitions import DEFINITIONS
from ml2_receiver.wire.frame import CDR_ENCAPSULATION
from ml2_tools.bags.bag_reader import Bag
from ml2_tools.inspection.check import Check
from ml2_tools.inspection.inspection import inspect
from ros_messages import TYPES, string
from sound_bag import (
    BEGIN_NS,
    IMAGES,
    IMU,
    INFOS,
    METADATA,
    Message,
    compressed,
    config,
    sound,
    written,
)

MS = 1_000_000
PAIRS = "pairs with camera_info"

type Damage = Callable[[int, Message], Message | None]


def checks(tmp_path: Path, messages: list[Message]) -> dict[tuple[str, str], Check]:
    tmp_path.mkdir(exist_ok=True)
    found = inspect(Bag(written(tmp_path / "bag", messages)))
    return {(check.topic, check.check): check for check in found}


def damaged(topic: str, damage: Damage) -> list[Message]:
    """`damage` is given each message of the topic and its number, and takes it out by None."""
    messages, number = [], 0
    for message in sound():
        if message.topic != topic:
            messages.append(message)
            continue
        if (other := damage(number, message)) is not None:
            messages.append(other)
        number += 1
    return messages


def without(*numbers: int) -> Damage:
    return lambda number, message: None if number in numbers else message


def stamped(move_ns: Callable[[int], int]) -> Damage:
    return lambda number, it: replace(it, stamp_ns=it.stamp_ns + move_ns(number))


def logged(late_ns: int) -> Damage:
    return lambda number, it: replace(it, log_ns=it.log_ns + late_ns)


def test_of_a_sound_recording_every_check_is_ok(tmp_path: Path) -> None:
    found = checks(tmp_path, sound())
    assert [check for check in found.values() if check.verdict != "ok"] == []
    assert found[IMAGES, "messages"].figures == {"messages": 90, "broken": 0}
    assert found[IMAGES, "rate"].figures["rate_hz"] == pytest.approx(30, abs=1e-3)
    assert found[IMU, "rate"].figures["rate_hz"] == pytest.approx(200, abs=1e-3)
    assert found[IMAGES, PAIRS].figures["pairs"] == 90
    assert found[IMAGES, "transforms"].figures["exact"] == 90
    assert found[IMU, "latency"].figures["p99_ms"] == pytest.approx(10)
    assert sum(found[IMAGES, "jitter"].figures["histogram_counts"]) == 89  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("camera", "transport"), [("world_left", "compressed"), ("depth", "compressedDepth")]
)
def test_images_that_the_headset_compressed_are_checked_like_raw_ones(
    tmp_path: Path, camera: str, transport: str
) -> None:
    found = checks(tmp_path, compressed(sound(), camera))
    images = f"{IMAGES.replace('world_left', camera)}/{transport}"
    assert [check for check in found.values() if check.verdict != "ok"] == []
    assert found[images, PAIRS].figures["pairs"] == 90
    assert found[images, "pairs with metadata"].figures["pairs"] == 90
    assert found[images, "transforms"].figures["exact"] == 90
    assert found[images, "rate"].figures["rate_hz"] == pytest.approx(30, abs=1e-3)


@pytest.mark.parametrize("camera", ["world_left", "depth"])
def test_a_compressed_image_of_another_size_or_without_a_head_is_found(
    tmp_path: Path, camera: str
) -> None:
    messages = compressed(sound(), camera)
    kind = "sensor_msgs/msg/CompressedImage"
    resized = [replace(it, size=(9, 6)) if it.type == kind else it for it in messages]
    (images,) = {it.topic for it in messages if it.type == kind}
    check = checks(tmp_path / "resized", resized)[images, PAIRS]
    assert (check.verdict, "9, 6" in check.found) == ("wrong", True)
    message: Any = TYPES.deserialize_cdr(
        next(it for it in messages if it.topic == images).encoded(), kind
    )
    message.data = message.data[:1]
    cut = bytes(TYPES.serialize_cdr(message, kind))
    broken = [replace(it, payload=cut) if it.topic == images else it for it in messages]
    check = checks(tmp_path / "broken", broken)[images, "messages"]
    assert (check.verdict, check.figures["broken"]) == ("wrong", 90)


@pytest.mark.parametrize(
    ("topic", "damage", "check", "verdict", "figures"),
    [
        (IMAGES, without(40), "gaps", "wrong", {"gaps": 1, "missing": 1}),
        (IMAGES, without(*range(40, 45)), "gaps", "wrong", {"gaps": 1, "missing": 5}),
        (IMU, without(300), "gaps", "hint", {"gaps": 1, "missing": 1}),
        (IMU, without(*range(300, 400)), "gaps", "wrong", {"gaps": 1, "missing": 100}),
        (IMU, lambda n, it: None if n % 4 else it, "rate", "hint", {}),
        (IMAGES, stamped(lambda n: 5 * MS * (n % 2)), "jitter", "hint", {}),
        (IMAGES, stamped(lambda n: 12 * MS * (n % 2)), "jitter", "wrong", {}),
        (IMAGES, stamped(lambda n: -40 * MS * (n == 7)), "stamps", "wrong", {"steps_back": 1}),
        (
            IMU,
            stamped(lambda n: -5 * MS * (n == 7)),
            "stamps",
            "wrong",
            {"repeated": 1, "steps_back": 0},
        ),
        (INFOS, without(40), PAIRS, "wrong", {"images_alone": 1, "camera_info_alone": 0}),
        (IMAGES, without(40), PAIRS, "wrong", {"images_alone": 0, "camera_info_alone": 1}),
        (METADATA, without(40), "pairs with metadata", "wrong", {"images_alone": 1}),
        (INFOS, stamped(lambda _: 1), PAIRS, "wrong", {"pairs": 0}),
        (INFOS, lambda n, it: replace(it, size=(9, 6)), PAIRS, "wrong", {}),
        (INFOS, lambda n, it: replace(it, frame="elsewhere"), PAIRS, "wrong", {}),
        (IMU, logged(500 * MS), "latency", "hint", {"p99_ms": 510}),
        (IMU, logged(-20 * MS), "latency", "wrong", {"min_ms": -10}),
        (IMU, logged(3_600_000 * MS), "latency", "hint", {}),
        (IMU, lambda n, it: replace(it, payload=b"\0\1\0\0x"), "messages", "wrong", {}),
        (METADATA, lambda n, it: replace(it, payload=b""), "messages", "wrong", {"broken": 90}),
    ],
)
def test_damage_is_found(
    tmp_path: Path, topic: str, damage: Damage, check: str, verdict: str, figures: dict[str, Any]
) -> None:
    found = checks(tmp_path, damaged(topic, damage))
    where = IMAGES if check.startswith("pairs") else topic
    assert found[where, check].verdict == verdict
    for key, value in figures.items():
        assert found[where, check].figures[key] == pytest.approx(value), key


@pytest.mark.parametrize(
    ("damage", "verdict", "figures"),
    [
        (lambda n, it: None if 60 < n < 80 else it, "wrong", {"uncovered": 11}),
        (lambda n, it: None if n < 15 else it, "hint", {"before_or_after": 8}),
        (lambda n, it: replace(it, stamp_ns=it.stamp_ns + 1), "ok", {"exact": 0, "between": 89}),
        (lambda n, it: replace(it, stamp_ns=it.stamp_ns - BEGIN_NS), "wrong", {"exact": 0}),
        (lambda n, it: replace(it, frame="elsewhere"), "wrong", {}),
    ],
)
def test_missing_transforms_are_found(
    tmp_path: Path, damage: Damage, verdict: str, figures: dict[str, int]
) -> None:
    found = checks(tmp_path, damaged("/tf", damage))[IMAGES, "transforms"]
    assert found.verdict == verdict, found
    for key, value in figures.items():
        assert found.figures[key] == pytest.approx(value, abs=2), key


def test_a_transform_said_twice_is_a_hint(tmp_path: Path) -> None:
    again = [it for it in sound() if it.topic == "/tf"][3]
    found = checks(tmp_path, [*sound(), replace(again, log_ns=again.log_ns + 1)])
    check = found["magicleap_world -> world_left_optical_frame", "stamps"]
    assert check.verdict == "hint"
    assert check.figures["repeated"] == 1


def test_transforms_may_come_in_any_order(tmp_path: Path) -> None:
    late = damaged("/tf", lambda n, it: replace(it, log_ns=it.log_ns + 30 * MS * (n % 2)))
    assert {it.verdict for it in checks(tmp_path, late).values()} == {"ok"}


def test_transforms_in_a_ring_are_no_place(tmp_path: Path) -> None:
    ring = [replace(it, frame="magicleap_world") for it in sound() if it.topic == "/tf"]
    images = [replace(it, frame="magicleap_world") for it in sound() if it.topic == IMAGES]
    infos = [replace(it, frame="magicleap_world") for it in sound() if it.topic == INFOS]
    found = checks(tmp_path, [*ring, *images, *infos])
    assert found[IMAGES, "transforms"].found == "the transforms form a loop"


def test_what_the_headset_promised_counts_more_than_what_came(tmp_path: Path) -> None:
    """Every second image is missing throughout, which stamps alone do not show."""
    entry = {"topic": IMAGES, "type": "sensor_msgs/msg/Image", "qos": "image", "role": "image"}
    stream = {"result": "applied", "values": {"update_rate": 30}, "reason": None, "topics": [entry]}
    text = json.dumps({"headset": "h", "session": "s", "streams": {"world_left": stream}})
    promised = replace(config(), payload=string(text))
    halved = damaged(IMAGES, lambda n, it: None if n % 2 else it)
    found = checks(tmp_path, [promised, *halved])
    assert found[IMAGES, "rate"].verdict == found[IMAGES, "gaps"].verdict == "wrong"
    assert found[IMAGES, "gaps"].figures["missing"] == 44


def test_a_recording_of_our_own_is_read_too(tmp_path: Path) -> None:
    bag_scene.record(tmp_path / "walk", 3)
    found = {(it.topic, it.check): it for it in inspect(Bag(tmp_path / "walk"))}
    assert found["/magic_leap2/battery", "messages"].found == "3 messages"
    assert found["/magic_leap2/world_left/image_raw", "rate"].figures["rate_hz"] == 1


def test_the_command_shows_what_is_wrong_and_ends_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = written(tmp_path / "bag", damaged(IMAGES, without(40, 41)))
    assert main(["inspect", str(bag)]) == 1
    said = capsys.readouterr().out
    assert f"wrong {IMAGES}: gaps: 2 of 90 missing in 1 gaps, the longest 100.0 ms" in said
    row = next(line for line in said.splitlines() if line.split()[:1] == [IMAGES])
    assert row.split()[1:4] == ["88", "30.00", "2"]


def test_the_command_ends_with_0_when_all_is_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = written(tmp_path / "bag", sound())
    assert main(["inspect", str(bag), "--json"]) == 0
    objects = json.loads(capsys.readouterr().out)
    assert {it["verdict"] for it in objects} == {"ok"}
    assert main(["inspect", str(bag)]) == 0


def test_what_is_no_recording_is_said_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "thesis.mcap").write_text("precious")
    assert len(refusal("inspect", tmp_path).strip().splitlines()) == 1


def test_a_recording_without_stamps_is_no_pass(tmp_path: Path) -> None:
    with (tmp_path / "notes.mcap").open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("note", "jsonschema", b"{}")
        channel = writer.register_channel("/notes", "json", schema)
        writer.add_message(channel, 1, b"{}", 1)
        writer.finish()
    assert "/notes (note)" in refusal("inspect", tmp_path)


def test_a_type_that_is_not_read_is_said(tmp_path: Path) -> None:
    type = "sensor_msgs/msg/Temperature"
    assert type not in DEFINITIONS
    unknown = Message("/room", BEGIN_NS, BEGIN_NS, type, payload=CDR_ENCAPSULATION + bytes(60))
    found = checks(tmp_path, [*sound(), unknown])["/room", "messages"]
    assert (found.verdict, type in found.found) == ("hint", True)


def test_what_several_topics_have_in_common_is_said_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    replayed = [replace(it, log_ns=it.log_ns + 3_600_000 * MS) for it in sound()]
    assert main(["inspect", str(written(tmp_path / "bag", replayed))]) == 0
    lines = [it for it in capsys.readouterr().out.splitlines() if it.startswith("hint")]
    (line,) = lines
    assert "latency of 5 topics" in line


def test_texts_of_other_nodes_are_neither_configuration_nor_metadata(tmp_path: Path) -> None:
    camera = replace(config(), topic="/other/image_raw", type="sensor_msgs/msg/Image")
    others = [
        replace(config(), topic=topic, payload=string(text))
        for topic, text in (
            ("/slam/config", "hello"),
            ("/slam/metadata", "[1]"),
            ("/other/metadata", "exposure 3 ms"),
        )
    ]
    camera = replace(camera, stamp_ns=BEGIN_NS, payload=None)
    found = checks(tmp_path, [*others, camera, *sound()])
    assert {found[it.topic, "messages"].verdict for it in others} == {"ok"}
    assert ("/other/image_raw", "pairs with metadata") not in found
    assert found[IMAGES, "pairs with metadata"].verdict == "ok"


@pytest.mark.parametrize(
    "text",
    [
        "no JSON",
        '{"stamp": {"sec": 1000000000000000000000, "nanosec": 0}}',
        '{"stamp": {"sec": -1e18, "nanosec": 1e300}}',
    ],
)
def test_metadata_that_are_not_like_the_others_are_broken(tmp_path: Path, text: str) -> None:
    found = checks(
        tmp_path, damaged(METADATA, lambda n, it: it if n else replace(it, payload=string(text)))
    )
    assert found[METADATA, "messages"].figures == {"messages": 90, "broken": 1}
    assert found[METADATA, "messages"].verdict == "wrong"

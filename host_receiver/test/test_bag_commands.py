"""Every command that reads recordings finds each message once, in whatever form it is."""

import csv
import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader
from rosbags.rosbag2 import Reader

from bag_forms import FORMS, NOISE, REQUEST, Row, sound_rows
from ml2_receiver.cli import main
from ml2_tools.bags.indexed_bag import History, IndexedBag
from ml2_tools.evaluation.sequence import read_sequence
from ml2_tools.viewing.recorded_source import RecordedSource
from playback_scene import played
from sound_bag import IMAGES, IMU, METADATA, PREFIX

ROWS = sound_rows()
COUNTS = Counter(it.topic for it in ROWS)
# The forms that rosbags reads: an index that has all channels or none, and files that follow.
OF_ROSBAGS = [
    "zstd",
    "lz4",
    "uncompressed",
    "no chunks",
    "one chunk",
    "a chunk per message",
    "no summary offsets",
    "no CRCs",
    "no index",
    "no summary",
    "rosbags",
    "rosbags, compressed",
    "rosbag2",
]


@pytest.fixture(params=FORMS)
def folder(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    FORMS[request.param](tmp_path / "walk", ROWS)
    return tmp_path / "walk"


def payloads(topic: str) -> list[bytes]:
    return [it.payload for it in ROWS if it.topic == topic]


def test_the_forms_have_what_the_library_of_mcap_reads_from_end_to_end(folder: Path) -> None:
    found: set[Row] = set()
    for file in folder.glob("*.mcap"):
        with file.open("rb") as stream:
            reader = NonSeekingReader(stream).iter_messages(log_time_order=False)
            try:
                for schema, channel, message in reader:
                    type, time_ns = schema.name if schema else "", message.log_time
                    found.add(
                        Row(channel.topic, type, time_ns, message.data, channel.message_encoding)
                    )
            except McapError:
                assert file.stat().st_size == 0 or file.read_bytes()[-8:-5] != b"\x89MC"
    assert found >= set(ROWS)
    assert Counter(it.topic for it in found if it.topic in COUNTS) == COUNTS


@pytest.fixture
def inspected(capsys: pytest.CaptureFixture[str]) -> Callable[[Path], Any]:
    """Inspects a recording; returns the number of messages by topic, and the checks."""

    def inspected(folder: Path) -> Any:
        assert main(["inspect", str(folder), "--json"]) == 0
        checks = json.loads(capsys.readouterr().out)
        counts = {
            it["topic"]: it["figures"]["messages"] for it in checks if it["check"] == "messages"
        }
        return counts, checks

    return inspected


@pytest.mark.parametrize("form", OF_ROSBAGS)
def test_inspect_counts_what_rosbags_counts(
    form: str, tmp_path: Path, inspected: Callable[[Path], Any]
) -> None:
    folder = tmp_path / "walk"
    FORMS[form](folder, ROWS)
    whole = folder if (folder / "metadata.yaml").exists() else next(folder.glob("*.mcap"))
    with Reader(whole) as reader:
        theirs = Counter(connection.topic for connection, _, _ in reader.messages())
    assert theirs == inspected(folder)[0] == COUNTS


def test_inspect_counts_every_message_and_finds_nothing_wrong(
    folder: Path, inspected: Callable[[Path], Any]
) -> None:
    counts, checks = inspected(folder)
    assert {topic: counts[topic] for topic in COUNTS} == COUNTS
    assert all(it["verdict"] == "ok" for it in checks if it["topic"] in COUNTS)


def test_play_sends_every_message(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sink = played(folder, REQUEST, "--rate", "1000")
    sent = {topic: payloads(topic) for topic in COUNTS if topic != f"{PREFIX}/config"}
    assert {
        it if it[0] == "/" else f"{PREFIX}/{it}": of for it, of in sink.payloads.items()
    } == sent
    said = capsys.readouterr()
    assert f"played {len(ROWS) - 1} messages" in said.out
    assert f"1 of {PREFIX}/config" in said.err


def test_export_writes_every_image_and_sample(folder: Path, tmp_path: Path) -> None:
    out = ["--euroc", str(tmp_path / "out"), "--kalibr", str(tmp_path / "kalibr")]
    imu = ["--imu", "imu_left", *NOISE]
    assert main(["export", *out, "--bag", str(folder), "--cameras", "world_left", *imu]) == 0
    for sensor, topic in (("cam0", IMAGES), ("imu0", IMU)):
        with (tmp_path / "out/mav0" / sensor / "data.csv").open(newline="") as file:
            assert sum(not row[0].startswith("#") for row in csv.reader(file)) == COUNTS[topic]


@pytest.mark.parametrize("form", FORMS)
def test_evaluate_reads_every_image_and_pose(form: str, tmp_path: Path) -> None:
    FORMS[form](tmp_path / "walk", [it for it in ROWS if it.topic != METADATA])
    sequence = read_sequence(tmp_path / "walk", "world_left")
    assert len(list(sequence.images())) == sequence.images_sent == COUNTS[IMAGES]
    # The stamps of images, each of which has a transform.
    assert len(sequence.reference) == COUNTS["/tf"]


def test_view_finds_every_message_at_its_time(folder: Path) -> None:
    bag = IndexedBag(folder)
    assert {topic: bag.counts[topic] for topic in COUNTS} == COUNTS
    assert [it.payload for it in bag.after(0) if it.topic == IMU] == payloads(IMU)
    assert (bag.begin_ns, bag.end_ns) == (ROWS[0].time_ns, max(it.time_ns for it in ROWS))
    page = RecordedSource(folder)
    assert page.allowed.length_s == (bag.end_ns - bag.begin_ns) / 1e9
    assert (page.left_out, page.apart) == (bag.left_out, [])
    middle_ns = ROWS[len(ROWS) // 2].time_ns
    for topic in (IMU, IMAGES, METADATA):
        newest = [it.payload for it in ROWS if it.topic == topic and it.time_ns <= middle_ns][-7:]
        found = bag.until(middle_ns, {topic: History(7, None)})
        assert [it.payload for it in found] == newest

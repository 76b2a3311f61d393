"""A recording with several headsets: each command asks which, and reads that one."""

import json
from collections import Counter
from pathlib import Path

import pytest

from bag_forms import NOISE, REQUEST, Row, sound_rows, text, write
from command_line import refusal
from ml2_receiver.cli import main
from ml2_receiver.errors import RecordingError
from ml2_tools.bags.bag_reader import BagReader
from ml2_tools.bags.indexed_bag import IndexedBag
from ml2_tools.evaluation.sequence import read_sequence
from playback_scene import played
from sound_bag import METADATA, PREFIX

SECOND = f"/robot2{PREFIX}"
FIRST_ROWS = sound_rows()
# The second headset comes later, and has half of the messages.
SECOND_ROWS = [
    Row(it.topic, it.type, it.time_ns + 10**9, it.payload)
    for number, it in enumerate(sound_rows("robot2"))
    if number == 0 or number % 2
]
DEVICE = '{"headset": "the second", "session": "s", "streams": {}}'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags") / "walk"
    config, *rest = SECOND_ROWS
    said = Row(config.topic, config.type, config.time_ns, text("", DEVICE).payload)
    rows = sorted([*FIRST_ROWS, said, *rest], key=lambda it: it.time_ns)
    write(folder / "a.mcap", [it for it in rows if "metadata" not in it.topic])
    return folder


def commands(folder: Path, out: Path) -> list[list[str | Path]]:
    return [
        ["play", folder, "--insecure"],
        ["export", "--kalibr", out, "--bag", folder],
        ["evaluate", "--camera", "world_left", "--bag", folder, "--out", out],
        ["view", folder, "--no-browser"],
    ]


def test_every_command_asks_which(folder: Path, tmp_path: Path) -> None:
    for command in commands(folder, tmp_path):
        said = refusal(*command)
        assert f"several headsets: {PREFIX}, {SECOND}" in said
        assert "--headset" in said
        assert "the second" in said


def test_a_name_of_none_is_told_with_the_choices(folder: Path, tmp_path: Path) -> None:
    asked: list[list[str | Path]] = [*commands(folder, tmp_path), ["inspect", folder]]
    for command in asked:
        said = refusal(*command, "--headset", "robot3")
        assert f"no headset 'robot3'; it has {PREFIX}, {SECOND}" in said


@pytest.mark.parametrize("name", [SECOND, SECOND[1:], "robot2", "the second"])
def test_a_headset_has_several_names(folder: Path, name: str) -> None:
    reader = BagReader(folder, name)
    assert (reader.prefix, reader.config.headset) == (SECOND, "the second")


def test_a_name_of_two_headsets_is_not_enough(tmp_path: Path) -> None:
    write(tmp_path / "a.mcap", [*FIRST_ROWS, *sound_rows("robot2")])
    with pytest.raises(RecordingError, match="several headsets of the name 'h': "):
        BagReader(tmp_path, "h")


@pytest.mark.parametrize(("prefix", "rows"), [(PREFIX, FIRST_ROWS), (SECOND, SECOND_ROWS)])
def test_each_command_reads_the_chosen_one_alone(
    folder: Path,
    tmp_path: Path,
    prefix: str,
    rows: list[Row],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """With its own transforms, although all are on /tf."""
    rows = [it for it in rows if "metadata" not in it.topic]
    counts = Counter(it.topic for it in rows)
    chosen = ["--headset", prefix]

    bag = IndexedBag(folder, prefix)
    assert bag.counts == counts
    assert (bag.begin_ns, bag.end_ns) == (rows[0].time_ns, rows[-1].time_ns)

    assert main(["inspect", str(folder), "--json", *chosen]) in (0, 1)
    said = capsys.readouterr()
    checks = json.loads(said.out)
    found = {it["topic"]: it["figures"]["messages"] for it in checks if it["check"] == "messages"}
    assert found == counts
    assert "messages of other headsets" in said.err

    sink = played(folder, REQUEST, "--rate", "1000", *chosen)
    sent = {it if it[0] == "/" else f"{prefix}/{it}": of for it, of in sink.payloads.items()}
    for topic, payloads in sent.items():
        assert payloads == [it.payload for it in rows if it.topic == topic]

    sequence = read_sequence(folder, "world_left", prefix)
    assert len(sequence.stamps_ns) == counts[f"{prefix}/world_left/image_raw"]
    assert len(sequence.reference) == counts["/tf"]

    imu = ["--imu", "imu_left", *NOISE]
    out = str(tmp_path / "out")
    assert main(["export", "--kalibr", out, "--bag", str(folder), *chosen, *imu]) == 0
    assert f"{prefix}/world_left/image_raw" in (tmp_path / "out/camchain.yaml").read_text()


def test_inspect_of_all_reads_both(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["inspect", str(folder), "--json"])
    topics = {it["topic"] for it in json.loads(capsys.readouterr().out)}
    assert {it.topic for it in (*FIRST_ROWS, *SECOND_ROWS) if "metadata" not in it.topic} <= topics
    assert METADATA not in topics


def test_it_is_for_recordings(tmp_path: Path) -> None:
    for command in (
        ("export", "--kalibr", tmp_path / "out"),
        ("evaluate", "--camera", "world_left", "--live"),
        ("view", "--no-browser"),
    ):
        assert "--headset is of a recording" in refusal(*command, "--headset", "robot2")

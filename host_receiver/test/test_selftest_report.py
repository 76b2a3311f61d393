"""The file of a self-test: it can be read again, and it has nothing that nobody may read."""

import contextlib
import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

import ros_messages
from command_line import refusal
from ml2_receiver.cli import main
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.errors import ReceiverError
from ml2_tools.commands import selftest
from ml2_tools.selftest.evidence import Evidence, read_session
from ml2_tools.selftest.report import DATA, names_of, numbers_of, read_verdicts, write_report
from ml2_tools.selftest.sessions import STEPS
from ml2_tools.selftest.verdict import Verdict, as_assumed, differs, unknown, within
from sound_bag import BEGIN_NS, IMAGES, PREFIX, Message, sound, written

SERIAL, NAME, SESSION = "G5A0CANARY", "Anna's canary", "5e55104ca9a9"
EYES = f"{PREFIX}/eye_nasal_left/image_raw"
MAP = f"{PREFIX}/map/state"
PIXELS, PLACE = b"canary of pixels", b"canary's living room"
LINES = [
    f"I ml2-sensors: connected to 192.168.7.77:7755, {NAME}",
    "I wlan0 02:ca:4a:12:34:56 fe80::ca4a:1:2:3",
    "-----BEGIN PRIVATE KEY-----\ncanarykey\n-----END PRIVATE KEY-----",
    f"I pair ml2s://10.9.8.7:40001?fp={'ca' * 32}&token={'4a' * 16}",
    f"I serial {SERIAL}, session {SESSION}, of PC 7",
]
CANARIES = (
    *(SERIAL, NAME, SESSION, "192.168.7.77", "10.9.8.7", "02:ca:4a:12:34:56", "fe80::ca4a:1:2:3"),
    *("of PC 7", "canarykey", "ca" * 32, "4a" * 16, PIXELS.decode(), PLACE.decode()),
)
VERDICTS = [
    as_assumed("mltime", 0.25, "ms"),
    differs("null_buffers", f"depth flags of {SERIAL}", switch="depth_center.flags=true"),
    unknown("jpeg_encoder", "no recording has RGB"),
]


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """One with images of an eye, the names of its headset, and that of a map."""
    text = {"headset": NAME, "session": SESSION, "streams": {}, "device_id": SERIAL}
    payload = ros_messages.string(json.dumps(text))
    config = Message(f"{PREFIX}/config", 0, BEGIN_NS, "std_msgs/msg/String", payload=payload)
    images = [it for it in sound() if it.topic == IMAGES]
    eyes = [replace(it, topic=EYES, payload=it.encoded() + PIXELS) for it in images]
    place = Message(MAP, 0, BEGIN_NS, "diagnostic_msgs/msg/DiagnosticArray", payload=PLACE)
    return written(tmp_path / "bag", [config, *sound(), *eyes, place])


def report(tmp_path: Path, recording: Path) -> Path:
    file = tmp_path / "report.zip"
    evidence = Evidence([read_session(recording)], LINES)
    write_report(file, VERDICTS, evidence, numbers_of(recording), {*names_of(recording), "PC 7"})
    return file


def test_verdicts_are_a_list_of_five_keys(tmp_path: Path, recording: Path) -> None:
    with zipfile.ZipFile(report(tmp_path, recording)) as archive:
        found = json.loads(archive.read("verdicts.json"))
    assert [set(it) for it in found] == [{"fact", "verdict", "measured", "unit", "switch"}] * 3
    assert found[0] == {
        "fact": "mltime",
        "verdict": "as assumed",
        "measured": 0.25,
        "unit": "ms",
        "switch": "",
    }


def test_no_canary_is_in_the_bytes(tmp_path: Path, recording: Path) -> None:
    parts = []
    with zipfile.ZipFile(report(tmp_path, recording)) as archive:
        for name in archive.namelist():
            parts.append(archive.read(name))
        reader = make_reader(io.BytesIO(archive.read(DATA)))
        messages = [(channel.topic, it.data) for _, channel, it in reader.iter_messages()]
    parts += [data for _, data in messages]
    found = [it for it in CANARIES if any(it.encode() in part for part in parts)]
    assert found == []
    topics = {topic for topic, _ in messages}
    assert f"{PREFIX}/imu_left/imu" in topics
    assert "/tf" in topics
    assert topics.isdisjoint({IMAGES, EYES, MAP, f"{PREFIX}/config"})


def test_a_report_is_shown_again(
    tmp_path: Path, recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = report(tmp_path, recording)
    assert [it.fact for it in read_verdicts(file)] == [it.fact for it in VERDICTS]
    assert main(["headset", "selftest", "--read", str(file)]) == 1
    shown = capsys.readouterr().out
    for words in ("0.25 ms", "depth_center.flags=true", "no recording has RGB"):
        assert words in shown


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("other.json", "[]"),
        ("verdicts.json", "["),
        ("verdicts.json", "[1]"),
        ("verdicts.json", '[{"fact": "a", "other": 1}]'),
        ("verdicts.json", "{}x"),
    ],
)
def test_another_archive_is_refused(name: str, text: str, tmp_path: Path) -> None:
    file = tmp_path / "other.zip"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(name, text)
    with pytest.raises(ReceiverError, match="no report of a self-test"):
        read_verdicts(file)


_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda it: st.lists(it, max_size=3) | st.dictionaries(st.text(max_size=9), it, max_size=3),
    max_leaves=5,
)
_ROWS = st.fixed_dictionaries(
    {"fact": _VALUES, "verdict": _VALUES},
    optional={"measured": _VALUES, "unit": _VALUES, "switch": _VALUES},
)


@given(st.lists(_ROWS, max_size=3) | _VALUES)
def test_verdicts_of_any_kind_are_shown_or_refused(tmp_path_factory: Any, rows: object) -> None:
    file = tmp_path_factory.mktemp("any") / "any.zip"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("verdicts.json", json.dumps(rows))
    try:
        verdicts = read_verdicts(file)
    except ReceiverError:
        return  # which the command shows as every other
    assert len(verdicts) == len(json.loads(json.dumps(rows)))
    with contextlib.redirect_stdout(io.StringIO()):
        assert main(["headset", "selftest", "--read", str(file)]) in (0, 1)


def test_what_is_no_archive_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "text.zip"
    file.write_text("no archive")
    assert "no report of a self-test" in refusal("headset", "selftest", "--read", str(file))
    missing = str(tmp_path / "missing.zip")
    assert "No such file" in refusal("headset", "selftest", "--read", missing)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--read", "a.zip", "--apply"], "--apply is for a test"),
        (["--read", "a.zip", "--simulated"], "--simulated is for a test"),
        (
            [it for step in STEPS for it in ("--skip", step)],
            "expected a step of everything, video, other_modes, openxr, found all skipped",
        ),
    ],
)
def test_options_that_do_not_belong_together_are_refused(options: list[str], words: str) -> None:
    assert words in refusal("headset", "selftest", *options)


def test_only_what_differs_beyond_doubt_is_applied(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    little = within("camera_rates", 31.0, 29.5, 30.5, "Hz", "world_left.format=h264")
    by_far = within("depth_rates", 5.0, 29.0, 31.0, "Hz", "depth_center.update_rate=5")
    said = differs("null_buffers", "depth flags", switch="depth_center.flags=true")
    selftest.apply([little, by_far, said, *VERDICTS[::2]])
    values = ConfigFile.of_user().load().values
    assert values["depth_center.update_rate"] == 5
    assert values["depth_center.flags"] is True
    assert values["world_left.format"] != "h264"
    assert capsys.readouterr().out.count("set ") == 2


def test_nothing_is_written_if_nothing_is_certain(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    selftest.apply([Verdict("mltime", "as assumed")])
    assert ConfigFile.of_user().is_packaged

"""`ml2-receiver headset` with a stand-in for adb and the headset behind it."""

import io
import json
import os
import re
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

import adb_stand_in
from command_line import refusal
from ml2_receiver.cli import main
from ml2_tools.headset import app

README = Path(__file__).parents[2] / "ml2-sensors-aar" / "app" / "README.md"
URI = f"ml2s://192.168.1.7:40001?fp={'a1' * 32}&token={'b2' * 16}"
DEPTH = "com.magicleap.permission.DEPTH_CAMERA"


class Adb:
    """The stand-in's folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.set()

    def set(self, **state: Any) -> None:
        (self.folder / "state.json").write_text(json.dumps(state))

    @property
    def state(self) -> dict[str, Any]:
        state: dict[str, Any] = json.loads((self.folder / "state.json").read_text())
        return state

    @property
    def commands(self) -> list[str]:
        """Returns the commands given to adb, except those for the log; each request is R."""
        calls = [json.loads(it) for it in (self.folder / "calls").read_text().splitlines()]
        lines = [" ".join(words) for words in calls if words[0] != "logcat"]
        return [re.sub(r"--es request \w{8}", "--es request R", line) for line in lines]


@pytest.fixture
def adb(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Adb:
    for name, value in adb_stand_in.installed(tmp_path).items():
        monkeypatch.setenv(name, value)
    return Adb(tmp_path)


def tell(action: str, extras: str = "") -> str:
    """The words behind `adb`."""
    service = "-n dev.ml2sensors.app/.StreamingService"
    command = f"shell am start-foreground-service {service} -a dev.ml2sensors.app.{action}"
    return f"{command} --es request R{extras}"


STATUS = tell("STATUS")


def test_an_app_is_installed(adb: Adb, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    apk = tmp_path / "my app.apk"
    apk.write_bytes(b"")
    assert main(["headset", "install", str(apk)]) == 0
    assert adb.commands == [f"install -r {apk}"]
    assert "ml2-receiver pair" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ((), [tell("START")]),
        (("--receiver", "desk"), [tell("RECEIVER", " --es receiver desk"), tell("START")]),
        (("--receiver", ""), [tell("RECEIVER", " --es receiver ''"), tell("START")]),
        (("--pair", URI), [tell("PAIR", f" --es uri '{URI}'"), tell("START")]),
        (
            ("--usb",),
            [
                "reverse tcp:7755 tcp:7755",
                tell("RECEIVER", " --es receiver 127.0.0.1:7755"),
                tell("START"),
            ],
        ),
        (
            ("--usb", "4711", "--pair", URI),
            [
                "reverse tcp:4711 tcp:4711",
                "reverse tcp:40001 tcp:40001",
                tell("PAIR", f" --es uri '{URI.replace('192.168.1.7', '127.0.0.1')}'"),
                tell("RECEIVER", " --es receiver 127.0.0.1:4711"),
                tell("START"),
            ],
        ),
    ],
)
def test_start_tells_the_app_how(adb: Adb, options: Sequence[str], expected: list[str]) -> None:
    assert main(["headset", "start", *options]) == 0
    assert adb.commands == [*expected, STATUS]


def test_start_waits_until_it_is_connected(adb: Adb, capsys: pytest.CaptureFixture[str]) -> None:
    adb.set(states=["connecting", "connecting", "connected"])
    assert main(["headset", "start"]) == 0
    assert adb.commands.count(STATUS) == 3
    assert "connected desk" in capsys.readouterr().out


def test_start_that_does_not_connect_shows_why(
    adb: Adb, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ml2_tools.commands.headset._CONNECT_TIMEOUT_S", 0)
    adb.set(states=["connecting"])
    assert main(["headset", "start"]) == 1
    assert "connecting desk" in capsys.readouterr().out


def test_stop(adb: Adb) -> None:
    assert main(["headset", "stop"]) == 0
    assert adb.commands == [tell("STOP")]


def test_status_shows_streams_and_what_is_missing(
    adb: Adb, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    assert main(["headset", "status"]) == 0
    title, _, world, depth, *permissions = map(str.split, capsys.readouterr().out.splitlines())
    words = "ML2 Sensors 0.1.0, connected desk, paired with desk, clock ±0.06 ms, heat light,"
    assert " ".join(title) == f"{words} battery 31.5 °C"
    assert world == ["world_left", "resting,", "hot", "900", "2"]
    assert " ".join(depth) == f"depth refused 0 0 {DEPTH} is not granted"
    assert permissions[-1] == [DEPTH, "not", "granted"]


def test_status_for_scripts_is_what_the_app_said(
    adb: Adb, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["headset", "status", "--json"]) == 0
    first, *rest = map(json.loads, adb_stand_in.STATUS.read_text().splitlines())
    said = {"status": first["status"], "streams": [it["stream"] for it in rest]}
    assert json.loads(capsys.readouterr().out) == said


def test_all_permissions_are_granted_and_what_runs_asks_anew(adb: Adb) -> None:
    assert main(["headset", "grant"]) == 0
    assert adb.state["granted"] == [
        "android.permission.CAMERA",
        DEPTH,
        "com.magicleap.permission.EYE_CAMERA",
        "com.magicleap.permission.EYE_TRACKING",
    ]
    assert adb.commands[0] == "shell pm grant dev.ml2sensors.app android.permission.CAMERA"
    assert adb.commands[-1] == tell("START")


def test_those_of_a_stream_are_granted_and_nothing_is_started(adb: Adb) -> None:
    adb.set(states=["off"])
    assert main(["headset", "grant", "depth"]) == 0
    assert adb.state["granted"] == [DEPTH]
    assert adb.commands[-1] == STATUS


@pytest.mark.parametrize(
    ("state", "words", "advice"),
    [
        ({"failure": "error: no devices/emulators found"}, ["stop"], "USB debugging"),
        ({"failure": "error: device unauthorized.\nThis adb server's"}, ["stop"], "allow this PC"),
        ({"failure": "error: more than one device/emulator"}, ["stop"], "ANDROID_SERIAL="),
        ({"failure": "error: device offline"}, ["stop"], "Unplug"),
        ({"failure": "error: closed"}, ["stop"], "error: closed"),
        ({"signature": "other"}, ["install", __file__], "adb uninstall dev.ml2sensors.app"),
        ({}, ["install", "/dev/null/nowhere.apk"], "there is no file /dev/null/nowhere.apk"),
        ({"installed": False}, ["start"], "ml2-receiver headset install"),
        ({"unknown": [DEPTH]}, ["grant"], f"Unknown permission: {DEPTH}"),
        ({}, ["grant", "depht"], "there is no stream 'depht', only "),
        ({"error": "this headset is paired with no receiver"}, ["start"], "the app: this headset"),
    ],
)
def test_what_went_wrong_is_said(
    adb: Adb, state: dict[str, Any], words: list[str], advice: str
) -> None:
    adb.set(**state)
    said = refusal("headset", *words)
    assert advice in said
    assert "Traceback" not in said


def test_an_app_that_does_not_answer(adb: Adb, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app, "_REPLY_TIMEOUT_S", 0.5)
    adb.set(silent=True)
    assert "did not answer" in refusal("headset", "stop")


@pytest.mark.parametrize(
    "line", ["no JSON", '{"request":"other","more":0,"error":"not ours"}', '{"request":', "[]"]
)
def test_lines_of_others_in_the_log_are_nobodys_answer(adb: Adb, line: str) -> None:
    adb.set(log=[line])
    assert main(["headset", "stop"]) == 0


@pytest.mark.parametrize("more", ['"0"', "null", "0.5", "1e999", "{}"])
def test_an_answer_of_another_version_is_said_to_be_one(
    adb: Adb, monkeypatch: pytest.MonkeyPatch, more: str
) -> None:
    def token(_: int) -> str:
        return "r" * 8

    monkeypatch.setattr("ml2_tools.headset.app.secrets.token_hex", token)
    adb.set(silent=True, log=[f'{{"request":"rrrrrrrr","more":{more}}}'])
    assert "more: expected" in refusal("headset", "stop")


@pytest.mark.parametrize("wrong", [URI[:-1], URI[2:], URI.replace("ml2s://", "ml2s:/")])
def test_a_wrong_uri_is_not_repeated(adb: Adb, wrong: str) -> None:
    assert "b2b2" not in refusal("headset", "start", "--pair", wrong)


def test_a_uri_is_read_from_a_file(adb: Adb, tmp_path: Path) -> None:
    file = tmp_path / "uri"
    file.write_text(f"{URI}\r\nthis machine is 10.0.0.1, too\n")
    assert main(["headset", "start", "--pair", str(file)]) == 0
    assert adb.commands[0] == tell("PAIR", f" --es uri '{URI}'")


@pytest.mark.parametrize("typed", [URI, f"  {URI}  \n", f"{URI}\npaired with 'a'\n"])
def test_a_uri_is_read_from_standard_input(
    adb: Adb, monkeypatch: pytest.MonkeyPatch, typed: str
) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(typed.encode())))
    assert main(["headset", "start", "--pair", "-"]) == 0
    assert adb.commands[0] == tell("PAIR", f" --es uri '{URI}'")


def test_no_other_user_can_read_the_token_in_the_words_of_a_program(
    adb: Adb, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO(URI))
    assert main(["headset", "start", "--usb", "--pair", "-"]) == 0
    assert any("PAIR" in line and "b2b2" in line for line in adb.commands)
    assert "b2b2" not in (tmp_path / "words").read_text()


@pytest.mark.parametrize(
    "typed", [b"", b"\n", b"x" * 100_000, b"\xff\xfe\n", URI[:-1].encode(), f"\n{URI}".encode()]
)
def test_standard_input_without_a_uri_pairs_nobody(
    adb: Adb, monkeypatch: pytest.MonkeyPatch, typed: bytes
) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(typed)))
    said = refusal("headset", "start", "--pair", "-")
    assert "on standard input" in said
    assert "b2b2" not in said
    assert len(said) < 400


def test_closed_standard_input_pairs_nobody(adb: Adb, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", None)
    assert "found nothing" in refusal("headset", "start", "--pair", "-")


def test_a_file_of_a_uri_is_regular_and_small(adb: Adb, tmp_path: Path) -> None:
    pipe, large, other = tmp_path / "pipe", tmp_path / "large", tmp_path / "other"
    os.mkfifo(pipe)
    large.write_text(f"{URI}\n".ljust(5000))
    other.write_bytes(URI[:-1].encode() + b"\xff\n")
    for file, reason in {
        pipe: "expected a regular file",
        Path("/dev/zero"): "expected a regular file",
        tmp_path: "expected a regular file",
        tmp_path / "none": "No such file",
        large: "expected at most 4096 bytes",
        other: f"in {other}, found another line",
    }.items():
        said = refusal("headset", "start", "--pair", str(file))
        assert reason in said
        assert str(file) in said
        assert "b2b2" not in said


def test_the_readme_of_the_app_has_every_command(adb: Adb) -> None:
    for words in (["start"], ["stop"], ["status"], ["start", "--pair", URI], ["start", "--usb"]):
        main(["headset", *words])
    documented = {_action(it) for it in README.read_text().splitlines() if "-a dev.ml2" in it}
    assert {_action(it) for it in adb.commands if "-a dev.ml2" in it} <= documented
    assert {"START", "STOP", "STATUS", "PAIR", "RECEIVER", "AT_BOOT", "COOL_DOWN"} == documented


def _action(line: str) -> str:
    words = shlex.split(line.replace("$service", "dev.ml2sensors.app/.StreamingService"))
    if "<<<" in words:
        words = shlex.split(words[-1])
    assert words[words.index("-n") + 1] == "dev.ml2sensors.app/.StreamingService"
    return words[words.index("-a") + 1].removeprefix("dev.ml2sensors.app.")

"""The archive of `doctor --bundle`: what a report needs, and nothing that is secret."""

import json
import os
import zipfile
from contextlib import nullcontext
from pathlib import Path

import pytest

from command_line import refusal
from ml2_receiver.cli import main
from ml2_receiver.generated.version import VERSION
from ml2_receiver.pairing.uri import PairingUri
from ml2_receiver.security.identity import Identity
from ml2_tools.commands import doctor
from ml2_tools.doctor import bundle
from ml2_tools.doctor.findings import Finding

TOKEN = "0123456789abcdef" * 2
PNG = b"\x89PNG\r\n\x1a\n" + bytes(range(256))
LINE = "[INFO] [1789.5] [{}]: {}\n"


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "logs"
    folder.mkdir()
    monkeypatch.setenv("ROS_LOG_DIR", str(folder))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setattr(doctor, "receivers", list)
    found = Finding("thing", "hint", "found it", "mend it")
    monkeypatch.setattr(doctor, "_findings", lambda _: [found])
    return folder


def bundled(folder: Path, *options: str) -> dict[str, bytes]:
    file = folder / "report.zip"
    assert main(["doctor", "--bundle", str(file), *options]) == 0
    with zipfile.ZipFile(file) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_it_has_what_a_report_needs(logs: Path, tmp_path: Path) -> None:
    (logs / "python3_1_2.log").write_text(LINE.format("robot1.ml2_receiver", "hello"))
    (logs / "python3_2_2.log").write_text(LINE.format("another_node", "private"))
    config = tmp_path / "my.yaml"
    config.write_text("/ml2_receiver: {ros__parameters: {battery: {enabled: true}}}")
    found = bundled(tmp_path, str(config))
    assert set(found) == {
        "versions.json",
        "findings.json",
        "configuration.yaml",
        "diagnostics.json",
        "logs/python3_1_2.log",
    }
    versions = json.loads(found["versions.json"])
    assert versions["ml2_receiver"] == VERSION
    assert versions["packages"]["cryptography"]
    assert json.loads(found["findings.json"])[0]["fix"] == "mend it"
    assert found["configuration.yaml"] == config.read_bytes()
    assert json.loads(found["diagnostics.json"]) == {"error": "no receiver runs here"}


def test_it_has_neither_keys_nor_tokens_nor_images(logs: Path, tmp_path: Path) -> None:
    identity = Identity.of(tmp_path / "config/ml2-sensors")
    key = identity.key_file.read_text()
    uri = str(PairingUri("10.0.0.1", 7756, identity.fingerprint, TOKEN))
    (logs / "python3_1_2.log").write_text(LINE.format("ml2_receiver", f"{uri} and {key}, then on"))
    (logs / "receiver.key").write_text(key)
    (logs / "image.png").write_bytes(PNG)
    (logs / "image.log").write_bytes(PNG + b"[ml2_receiver]")
    everything = b"".join(bundled(tmp_path, str(identity.key_file)).values())
    assert b"PRIVATE" not in everything
    assert not any(line.encode() in everything for line in key.splitlines())
    assert TOKEN.encode() not in everything
    assert b"PNG" not in everything
    assert b"then on" in everything
    assert identity.fingerprint.encode() in everything


def test_it_has_the_last_diagnostics_of_a_running_receiver(
    logs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Node:
        def rows(self, receiver: str, timeout_s: float) -> dict[str, dict[str, str]]:
            return {"session": {"headset": "mine", "message": f"{receiver} token={TOKEN}"}}

    monkeypatch.setattr(doctor, "receivers", lambda: ["one"])
    monkeypatch.setattr(doctor, "diagnostics_node", lambda: nullcontext(Node()))
    rows = json.loads(bundled(tmp_path, "--name", "robot1")["diagnostics.json"])
    assert rows == {"session": {"headset": "mine", "message": "robot1 token=<removed>"}}


def test_a_key_whose_beginning_was_cut_off_is_removed() -> None:
    assert bundle.without_secrets("MIGH\nAgEA\n-----END PRIVATE KEY-----\nok") == "<removed>\nok"
    assert bundle.without_secrets("ok\n-----BEGIN PRIVATE KEY-----\nMIGH") == "ok\n<removed>"


def test_of_large_and_many_logs_it_has_the_newest_part(logs: Path, tmp_path: Path) -> None:
    for number in range(8):
        file = logs / f"python3_{number}.log"
        file.write_text(LINE.format("ml2_receiver", "old") * 40_000)
        with file.open("a") as stream:
            stream.write(LINE.format("ml2_receiver", "new"))
        os.utime(file, (number, number))
    found = {name: data for name, data in bundled(tmp_path).items() if name.startswith("logs/")}
    assert set(found) == {f"logs/python3_{number}.log" for number in range(3, 8)}
    for data in found.values():
        assert len(data) <= 1_000_000
        assert data.startswith(b"[INFO]")
        assert data.endswith(b": new\n")


def test_the_users_own_configuration_is_taken_without_a_file(logs: Path, tmp_path: Path) -> None:
    assert b"packaged" in bundled(tmp_path)["configuration.yaml"]
    own = tmp_path / "config/ml2-sensors/config.yaml"
    own.parent.mkdir(parents=True)
    own.write_text("mine")
    assert bundled(tmp_path)["configuration.yaml"] == b"mine"


def test_a_file_that_cannot_be_written_is_an_error(logs: Path, tmp_path: Path) -> None:
    assert "cannot write" in refusal("doctor", "--bundle", tmp_path / "none/report.zip")
    os.mkfifo(tmp_path / "pipe")
    assert "expected a regular file" in refusal("doctor", "--bundle", tmp_path / "pipe")

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from ml2_receiver.cli import main
from ml2_receiver.transport.discovery import FoundReceiver
from ml2_tools.commands import doctor
from ml2_tools.doctor.findings import Finding


@pytest.fixture(autouse=True)
def _nobody_announces(monkeypatch: pytest.MonkeyPatch) -> None:
    def find() -> Sequence[FoundReceiver]:
        return []

    monkeypatch.setattr(doctor, "find_receivers", find)


def test_it_looks_at_everything_and_says_what_to_do(capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["doctor", "--json"])
    found = json.loads(capsys.readouterr().out)
    checks = {each["check"] for each in found}
    assert {"Python", "ROS 2", "Fast DDS profile", "shared memory", "UDP buffers"} <= checks
    assert {"port 7755", "firewall", "mDNS", "ROS domain"} <= checks
    assert code == any(each["level"] == "wrong" for each in found)
    assert all(each["fix"] for each in found if each["level"] != "ok")


@pytest.mark.parametrize(("level", "code"), [("ok", 0), ("hint", 0), ("wrong", 1)])
def test_only_what_is_wrong_is_in_the_exit_code(
    level: str, code: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = Finding("thing", level, "found [it]", "mend it")  # type: ignore[arg-type]
    monkeypatch.setattr(doctor, "_findings", lambda _: [found])
    assert main(["doctor"]) == code
    printed = capsys.readouterr().out
    assert level in printed
    assert "found [it]" in printed
    assert "mend it" in printed


def test_the_node_name_of_the_thesis_is_explained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "config.yaml"
    file.write_text("config_ML_node: {ros__parameters: {battery: {enabled: true}}}")
    main(["doctor", "--json", str(file)])
    found = {each["check"]: each for each in json.loads(capsys.readouterr().out)}
    assert "config_ML_node" in found["configuration"]["found"]
    assert "--params-file" in found["configuration"]["fix"]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (None, ": cannot be read"),
        ("a: [", ":1: "),
        ("/**: {ros__parameters: {battery: {enabled: 7}}}", ":1: battery.enabled"),
    ],
)
def test_a_wrong_file_is_one_finding_beside_the_others(
    text: str | None, problem: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "config.yaml"
    if text is not None:
        file.write_text(text)
    assert main(["doctor", "--json", str(file)]) == 1
    found = {each["check"]: each for each in json.loads(capsys.readouterr().out)}
    assert {"Python", "mDNS", "ROS domain"} <= found.keys()
    assert found["configuration"]["level"] == "wrong"
    assert f"{file}{problem}" in found["configuration"]["found"]
    assert f"config check {file}" in found["configuration"]["fix"]

from pathlib import Path

import pytest

from ml2_receiver.cli import main

ROOT = Path(__file__).resolve().parents[2]


def test_a_good_file_lists_the_topics_it_starts(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["config", "check", str(ROOT / "config/config.yaml")]) == 0
    printed = capsys.readouterr()
    assert "/magic_leap2/world_center/image_raw" in printed.out
    assert "/tf" in printed.out
    assert "world_left" not in printed.out
    assert printed.err == ""


def test_topics_that_are_switched_off_are_not_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "config.yaml"
    file.write_text(
        "/**: {ros__parameters: {general: {topic_name: /lab},"
        " depth_center: {enabled: true, flags: true}}}"
    )
    assert main(["config", "check", str(file)]) == 0
    printed = capsys.readouterr().out
    assert "/lab/depth/flags" in printed
    assert "confidence" not in printed


def test_a_bad_file_has_one_line_per_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "config.yaml"
    file.write_text("/**:\n  ros__parameters:\n    gaze: {enabled: 1}\n    tf: {layout: tree}\n")
    assert main(["config", "check", str(file)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.splitlines() == [
        f"{file}:3: gaze.enabled: expected true or false, found 1",
        f"{file}:4: tf.layout: expected one of flat, rig, found tree",
    ]


def test_a_missing_file_is_one_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["config", "check", "/no/such/file.yaml"]) == 2
    assert (
        capsys.readouterr().err == "/no/such/file.yaml: cannot be read: No such file or directory\n"
    )

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from waiting import LIMIT_S

ROOT = Path(__file__).resolve().parents[2]
KOTLIN = "ml2-sensors-aar/src/main/kotlin/dev/ml2sensors"


def check(root: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(root / "config/generate.py"), "--check"]
    return subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False)


@pytest.fixture(scope="module")
def current(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("current")
    ignored = shutil.ignore_patterns("__pycache__", ".*")
    shutil.copytree(
        ROOT / "host_receiver/ml2_receiver",
        root / "host_receiver/ml2_receiver",
        symlinks=True,
        ignore=ignored,
    )
    generated = (f"{KOTLIN}/table", f"{KOTLIN}/generated", "native/generated")
    messages = "host_receiver/environment/messages"
    for folder in ("config", "docs", "unity_package", messages, *generated):
        shutil.copytree(ROOT / folder, root / folder, ignore=ignored)
    for file in ("pom.xml", "README.md"):
        shutil.copy(ROOT / file, root)
    assert check(root).returncode == 0
    return root


@pytest.fixture
def copy(current: Path, tmp_path: Path) -> Path:
    return shutil.copytree(current, tmp_path / "copy", symlinks=True)


def test_generated_files_are_current() -> None:
    result = check(ROOT)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize(
    ("file", "old", "new", "stale"),
    [
        (
            "config/streams.yaml",
            "frame: world_left_optical_frame",
            "frame: left",
            {f"{KOTLIN}/table/generated/StreamTable.kt", "docs/configuration.md"},
        ),
        ("config/streams.yaml", "doc: Joints", "doc: All joints", {"docs/configuration.md"}),
        ("config/facts.yaml", "equidistant k1-k4", "another", {"docs/unconfirmed.md"}),
        (
            "pom.xml",
            "<revision>",
            "<revision>9.",
            {f"{KOTLIN}/generated/Version.kt", "host_receiver/ml2_receiver/generated/version.py"},
        ),
    ],
)
def test_a_changed_source_makes_what_is_generated_from_it_stale(
    copy: Path, file: str, old: str, new: str, stale: set[str]
) -> None:
    text = (copy / file).read_text("utf-8")
    assert old in text
    (copy / file).write_text(text.replace(old, new, 1), "utf-8")
    result = check(copy)
    assert result.returncode == 1
    assert {line.partition(" is stale")[0] for line in result.stderr.splitlines()} == stale


def test_a_generated_file_changed_by_hand_is_stale(copy: Path) -> None:
    page = copy / "docs/configuration.md"
    page.write_text(page.read_text("utf-8") + "by hand\n", "utf-8")
    assert check(copy).returncode == 1


def test_a_stream_without_a_name_for_people_is_not_generated(copy: Path) -> None:
    table = copy / "config/streams.yaml"
    row = next(it for it in table.read_text("utf-8").splitlines() if "{section: battery" in it)
    added = row.replace("battery:", "humidity:").replace("topic: battery", "topic: humidity")
    table.write_text(table.read_text("utf-8").replace(row, f"{row}\n{added}"), "utf-8")
    result = check(copy)
    assert result.returncode == 1
    assert "expected a row for humidity in _NAMES of config/sensor_table.py" in result.stderr


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("world_left.calibration", "world_left.lens", "the configuration has no world_left.lens"),
        ("stage: attended", "stage: soon", "soon is none of"),
    ],
)
def test_a_fact_with_an_unknown_key_or_stage_is_not_generated(
    copy: Path, old: str, new: str, reason: str
) -> None:
    facts = copy / "config/facts.yaml"
    facts.write_text(facts.read_text().replace(old, new, 1))
    result = check(copy)
    assert result.returncode == 1
    assert reason in result.stderr

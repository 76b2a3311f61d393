"""The Unity package as the Unity Package Manager sees it."""

import filecmp
import json
import re
import subprocess
import sys
import tarfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "unity_package"
VERSION = ElementTree.parse(ROOT / "pom.xml").findtext(".//{*}revision")
GUID = re.compile(r"^guid: ([0-9a-f]{32})$", re.MULTILINE)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The tarball of `make unity-package`, unpacked as npm and Unity do."""
    archive = make_tarball()
    folder = tmp_path_factory.mktemp("project")
    with tarfile.open(archive) as packed:
        packed.extractall(folder, filter="data")
    assert [entry.name for entry in folder.iterdir()] == ["package"]
    return folder / "package"


def make_tarball() -> Path:
    subprocess.run([sys.executable, ROOT / "config/unity_tarball.py"], check=True)
    return ROOT / f"build/unity/dev.ml2sensors.unity-{VERSION}.tgz"


def test_equal_contents_make_equal_tarballs() -> None:
    first = make_tarball().read_bytes()
    assert make_tarball().read_bytes() == first


def test_package_json_is_what_unity_wants(installed: Path) -> None:
    about = json.loads((installed / "package.json").read_text())
    assert re.fullmatch(r"[a-z0-9-]+(\.[a-z0-9-]+){2,}", about["name"])
    assert about["version"] == VERSION
    assert re.fullmatch(r"\d{4}\.\d+", about["unity"])
    for version in about["dependencies"].values():
        assert re.fullmatch(r"\d+\.\d+\.\d+", version)
    for sample in about["samples"]:
        assert sample["displayName"]
        assert sample["description"]
        assert list((installed / sample["path"]).glob("*.cs"))
    for name in ["README.md", "CHANGELOG.md", "LICENSE.md", "Documentation~/index.md"]:
        assert (installed / name).is_file()


def test_each_asset_has_a_meta_and_each_meta_its_asset(installed: Path) -> None:
    entries = [path for path in installed.rglob("*") if is_imported(path.relative_to(installed))]
    metas = {path for path in entries if path.suffix == ".meta"}
    assets = {path for path in entries if path.suffix != ".meta"}
    assert {path.with_name(path.name + ".meta") for path in assets} == metas
    assert len(metas) > 50


def is_imported(path: Path) -> bool:
    """Unity's rule for what it ignores; Samples~ itself is ignored, not what is copied from it."""
    parts = path.parts[1:] if path.parts[0] == "Samples~" else path.parts
    return bool(parts) and not any(part.startswith(".") or part.endswith("~") for part in parts)


def test_guids_are_unique(installed: Path) -> None:
    found = [GUID.findall(meta.read_text()) for meta in installed.rglob("*.meta")]
    assert all(len(guids) == 1 for guids in found)
    assert len({guids[0] for guids in found}) == len(found)


def test_the_library_is_imported_for_android_only() -> None:
    sys.path.insert(0, str(ROOT / "config"))
    from unity_metas import ANDROID_LIBRARY

    enabled = re.findall(r"- first:\n +(\w+):.*\n +second:\n +enabled: (\d)", ANDROID_LIBRARY)
    assert enabled == [("Android", "1"), ("Any", "0"), ("Editor", "0")]


def test_assemblies_refer_to_assemblies_that_exist(installed: Path) -> None:
    definitions = [json.loads(path.read_text()) for path in installed.rglob("*.asmdef")]
    own = {definition["name"] for definition in definitions}
    unitys = {
        "Unity.Robotics.ROSTCPConnector.MessageGeneration",
        "Unity.XR.OpenXR",
        "UnityEngine.TestRunner",
        "UnityEditor.TestRunner",
    }
    referred = {name for definition in definitions for name in definition["references"]}
    assert referred <= own | unitys
    assert len(own) == len(definitions)


def test_scenes_refer_to_scripts_of_the_package(installed: Path) -> None:
    scripts = {
        GUID.findall(meta.read_text())[0]: meta.name for meta in installed.rglob("*.cs.meta")
    }
    scenes = [*installed.rglob("*.unity"), *(ROOT / "tests/unity_project").rglob("*.unity")]
    folders = {scene.parent.name for scene in scenes if "Samples~" in scene.parts}
    assert folders == {
        folder.name for folder in (installed / "Samples~").iterdir() if folder.is_dir()
    }
    for scene in scenes:
        referred = re.findall(r"m_Script: {fileID: 11500000, guid: (\w+)", scene.read_text())
        assert "Ml2SensorStreamer.cs.meta" in {scripts[guid] for guid in referred}


def test_what_scenes_and_materials_refer_to_is_there(installed: Path) -> None:
    """Files by guid, Unity's own aside, and objects of the same file by number."""
    known = {GUID.findall(meta.read_text())[0] for meta in installed.rglob("*.meta")}
    files = [*installed.rglob("*.unity"), *installed.rglob("*.mat")]
    assert files
    for file in files:
        text = file.read_text()
        guids = set(re.findall(r"guid: (\w{32})", text))
        assert {guid for guid in guids if not guid.startswith("0000000000000000")} <= known, file
        objects = set(re.findall(r"^--- !u!\d+ &(\d+)$", text, re.MULTILINE))
        assert set(re.findall(r"{fileID: (\d+)}", text)) - {"0"} <= objects, file


def test_a_local_project_takes_the_package_from_this_tree() -> None:
    project = ROOT / "tests/unity_project"
    manifest = json.loads((project / "Packages/manifest.json").read_text())
    location = manifest["dependencies"]["dev.ml2sensors.unity"].removeprefix("file:")
    assert (project / "Packages" / location).resolve() == PACKAGE


def test_the_library_is_that_of_the_build_and_not_in_git(installed: Path) -> None:
    library = "Plugins/Android/ml2-sensors.aar"
    built = ROOT / f"build/aar/ml2-sensors-unity-{VERSION}.aar"
    assert filecmp.cmp(installed / library, built, shallow=False)
    assert filecmp.cmp(PACKAGE / library, built, shallow=False)
    tracked = ["git", "ls-files", "-co", "--exclude-standard", "--", "*.aar"]
    assert subprocess.run(tracked, cwd=ROOT, check=True, capture_output=True).stdout == b""


def test_a_release_adds_the_package_to_the_branch_upm(
    installed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("AUTHOR_NAME", "AUTHOR_EMAIL", "COMMITTER_NAME", "COMMITTER_EMAIL"):
        monkeypatch.setenv(f"GIT_{name}", "release")
    for repository in (["--bare", "remote"], ["clone"]):
        subprocess.run(["git", "init", "--quiet", *repository], cwd=tmp_path, check=True)
    release: list[str | Path] = [ROOT / "config/upm_branch.sh", make_tarball(), "../remote"]
    for _ in range(2):
        subprocess.run(release, cwd=tmp_path / "clone", check=True)

    def git(*command: str) -> list[str]:
        words = ["git", "-C", str(tmp_path / "remote"), *command]
        return subprocess.run(words, check=True, capture_output=True, text=True).stdout.split("\0")

    files = [path for path in installed.rglob("*") if path.is_file()]
    pushed = git("ls-tree", "-r", "-z", "--name-only", "upm")
    assert sorted(filter(None, pushed)) == sorted(str(it.relative_to(installed)) for it in files)
    assert git("rev-list", "--count", "upm") == ["2\n"]

"""The folder of `make dist`."""

import filecmp
import json
import os
import re
import subprocess
import tarfile
import zipfile
from email.message import Message
from email.parser import BytesParser
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement

import archives
import dist
from dist import DIST, ROOT, VERSION

WHEEL = DIST / f"ml2_receiver-{VERSION}-py3-none-any.whl"
SDIST = DIST / f"ml2_receiver-{VERSION}.tar.gz"
BILLS = {
    "ml2_receiver": "pkg:pypi/ml2-receiver@{}",
    "ml2-sensors": "pkg:maven/dev.ml2sensors/ml2-sensors@{}?type=jar",
    "ml2-sensors-app": "pkg:maven/dev.ml2sensors/ml2-sensors-app@{}?type=jar",
    "ml2-headset": "pkg:maven/dev.ml2sensors/ml2-headset@{}?type=jar",
}


def bill(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((DIST / f"{name}-{VERSION}.cdx.json").read_text())
    return found


def metadata() -> Message:
    with zipfile.ZipFile(WHEEL) as packed:
        return BytesParser().parsebytes(packed.read(f"ml2_receiver-{VERSION}.dist-info/METADATA"))


def test_it_holds_a_package_for_each_user_and_a_checksum_for_each_file() -> None:
    names = {file.name for file in DIST.iterdir()}
    assert names == {
        "SHA256SUMS",
        WHEEL.name,
        SDIST.name,
        f"ml2-sensors-{VERSION}.aar",
        f"ml2-sensors-{VERSION}-maven.zip",
        f"ml2-sensors-{VERSION}.apk",
        f"ml2-sensors-unity-{VERSION}-mapping.txt",
        f"dev.ml2sensors.unity-{VERSION}.tgz",
        *(f"{name}-{VERSION}.cdx.json" for name in BILLS),
    }
    check = ["sha256sum", "--check", "--strict", "SHA256SUMS"]
    checked = subprocess.run(check, cwd=DIST, check=True, capture_output=True, text=True).stdout
    listed = {line.removesuffix(": OK") for line in checked.splitlines()}
    assert listed == names - {"SHA256SUMS"}


def test_nothing_is_left_to_build_after_a_release() -> None:
    variables = {name: it for name, it in os.environ.items() if not name.startswith("MAKE")}
    dry_run = ["make", "--dry-run", "build", "aar", "apk"]
    done = subprocess.run(
        dry_run, cwd=ROOT, env=variables, check=True, capture_output=True, text=True
    )
    assert done.stdout.splitlines() == [
        f"make: Nothing to be done for '{name}'." for name in ("build", "aar", "apk")
    ]


def test_the_maven_repository_is_that_of_the_build() -> None:
    with zipfile.ZipFile(DIST / f"ml2-sensors-{VERSION}-maven.zip") as packed:
        found = {name: sha256(packed.read(name)).digest() for name in packed.namelist()}
    folder = ROOT / "build/aar/repository"
    files = [file for file in folder.rglob("*") if file.is_file()]
    built = {str(file.relative_to(folder)): sha256(file.read_bytes()).digest() for file in files}
    assert found == built
    aar = f"dev/ml2sensors/ml2-sensors/{VERSION}/ml2-sensors-{VERSION}.aar"
    assert filecmp.cmp(folder / aar, DIST / f"ml2-sensors-{VERSION}.aar", shallow=False)


@pytest.mark.parametrize("name", BILLS)
def test_a_bill_of_materials_has_nothing_of_the_machine_or_the_time(name: str) -> None:
    text = json.dumps(bill(name))
    assert bill(name)["bomFormat"] == "CycloneDX"
    assert not {"serialNumber"} & bill(name).keys()
    assert "timestamp" not in bill(name)["metadata"]
    for path in (ROOT, Path.home(), "/tmp"):
        assert f"{path}/" not in text


@pytest.mark.parametrize(("name", "purl"), BILLS.items())
def test_a_bill_of_materials_names_its_package_and_a_version_of_each_part(
    name: str, purl: str
) -> None:
    found = bill(name)
    parts = [*found["components"], *filter(None, [found["metadata"].get("component")])]
    assert purl.format(VERSION) in [part["purl"] for part in parts]
    assert all(part["version"] for part in parts)
    assert len(parts) > 1


def test_the_receivers_bill_of_materials_has_what_the_wheel_requires_and_no_ros() -> None:
    required = [Requirement(text) for text in metadata().get_all("Requires-Dist", [])]
    direct = {normal(it.name) for it in required if it.marker is None}
    components = bill("ml2_receiver")["components"]
    versions = {normal(part["name"]): part["version"] for part in components}
    assert direct
    assert direct <= versions.keys()
    for requirement in required:
        if requirement.marker is None:
            assert versions[normal(requirement.name)] in requirement.specifier
    assert not {"rclpy", "pytest", "opencv-python-headless"} & versions.keys()


def test_the_receivers_bill_of_materials_has_what_its_page_contains() -> None:
    with zipfile.ZipFile(WHEEL) as packed:
        page = packed.read("ml2_tools/viewing/page/three.min.js")
        assert packed.read("ml2_tools/viewing/page/three.LICENSE.txt")
    (three,) = [it for it in bill("ml2_receiver")["components"] if it["name"] == "three"]
    assert three["licenses"] == [{"license": {"id": "MIT"}}]
    # three.js has the middle number of its version as its revision.
    assert f'"{three["version"].split(".")[1]}"'.encode() in page


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def test_the_unity_packages_parts_are_in_the_librarys_bill_of_materials() -> None:
    """The mapping names each class that was relocated into the Unity package."""
    mapping = (DIST / f"ml2-sensors-unity-{VERSION}-mapping.txt").read_text()
    originals = set(re.findall(r"^((?:kotlin|kotlinx)\.\w+)\S* -> ", mapping, re.MULTILINE))
    names = {part["name"] for part in bill("ml2-sensors")["components"]}
    assert {"kotlinx.coroutines", "kotlinx.serialization"} <= originals
    assert {
        "kotlin-stdlib",
        "kotlinx-coroutines-core-jvm",
        "kotlinx-serialization-json-jvm",
    } <= names


def test_equal_sources_make_equal_packages_of_the_receiver(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TZ", "Pacific/Kiritimati")
    monkeypatch.setenv("LC_ALL", "C")
    before = os.umask(0o077)
    try:
        again = dist.receiver_packages(tmp_path)
    finally:
        os.umask(before)
    assert filecmp.cmp(again, WHEEL, shallow=False)
    assert filecmp.cmp(tmp_path / SDIST.name, SDIST, shallow=False)


def test_no_archive_has_the_time_it_was_made_at() -> None:
    zips = [file for file in DIST.iterdir() if zipfile.is_zipfile(file)]
    tars = [file for file in DIST.iterdir() if tarfile.is_tarfile(file)]
    assert (len(zips), len(tars)) == (4, 2)
    for file in zips:
        with zipfile.ZipFile(file) as packed:
            assert {entry.date_time[0] for entry in packed.infolist()} == {1980}, file.name
    for file in tars:
        assert file.read_bytes()[4:8] == bytes(4)  # the time in the header of gzip
        with tarfile.open(file) as archive:
            entries = {(entry.mtime, entry.uid, entry.uname, entry.mode) for entry in archive}
        assert entries == {(archives.DATE_S, 0, "", 0o644)}, file.name

#!/usr/bin/env python3
"""Puts all that a release holds into build/dist: packages, bills of materials and SHA256SUMS.

`make dist` makes the Android packages, the app, the Unity package and the bills of materials of
Maven's modules first. Equal inputs make equal bytes, except for the signature of the app if its
key is another.
"""

import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from xml.etree import ElementTree

import wheel_environment
from archives import DATE_S, source_files, stored_zip, tar_gz, untar

ROOT = Path(__file__).resolve().parents[1]
VERSION = ElementTree.parse(ROOT / "pom.xml").findtext(".//{*}revision")
DIST = ROOT / "build/dist"
KOTLIN = ROOT / "ml2-sensors-aar"
CHECKSUMS = "SHA256SUMS"
# By its name in a release. The Unity package holds what ml2-sensors requires.
BUILT = {
    f"ml2-sensors-{VERSION}.aar": ROOT / f"build/aar/ml2-sensors-{VERSION}.aar",
    f"ml2-sensors-{VERSION}.apk": ROOT / f"build/apk/ml2-sensors-{VERSION}.apk",
    f"ml2-sensors-{VERSION}.cdx.json": KOTLIN / "target/bom.json",
    f"ml2-sensors-app-{VERSION}.cdx.json": KOTLIN / "app/target/bom.json",
    f"ml2-headset-{VERSION}.cdx.json": KOTLIN / "simulator/target/bom.json",
    f"dev.ml2sensors.unity-{VERSION}.tgz": ROOT / f"build/unity/dev.ml2sensors.unity-{VERSION}.tgz",
    f"ml2-sensors-unity-{VERSION}-mapping.txt": ROOT
    / f"build/aar/ml2-sensors-unity-{VERSION}-mapping.txt",
}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cyclonedx", type=Path, required=True, help="the program cyclonedx-py")
    options = parser.parse_args()
    shutil.rmtree(DIST, ignore_errors=True)
    DIST.mkdir(parents=True)
    for name, file in BUILT.items():
        shutil.copyfile(file, DIST / name)
    (DIST / f"ml2-sensors-{VERSION}-maven.zip").write_bytes(maven_repository())
    wheel = receiver_packages(DIST)
    bill = wheel.with_name(f"ml2_receiver-{VERSION}.cdx.json")
    bill.write_bytes(bill_of_materials(wheel, options.cyclonedx))
    (DIST / CHECKSUMS).write_text(checksums(DIST), "utf-8")
    print(f"wrote {DIST.relative_to(ROOT)}, {len(list(DIST.iterdir()))} files")
    return 0


def maven_repository() -> bytes:
    folder = ROOT / "build/aar/repository"
    files = filter(Path.is_file, folder.rglob("*"))
    return stored_zip({str(file.relative_to(folder)): file.read_bytes() for file in files})


def receiver_packages(output: Path) -> Path:
    """Builds the sdist, and the wheel from it; returns the wheel."""
    with tempfile.TemporaryDirectory() as made:
        sources = Path(made)
        for name, content in source_files(ROOT / "host_receiver").items():
            file = sources / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(content)
            file.chmod(0o644)
        build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(output), made]
        environment = os.environ | {"SOURCE_DATE_EPOCH": str(DATE_S)}
        quiet = subprocess.DEVNULL
        subprocess.run(build, check=True, env=environment, stdout=quiet, umask=0o022)
    sdist = output / f"ml2_receiver-{VERSION}.tar.gz"
    sdist.write_bytes(tar_gz(untar(sdist.read_bytes())))
    (wheel,) = output.glob(f"ml2_receiver-{VERSION}-*.whl")
    return wheel


def bill_of_materials(wheel: Path, cyclonedx: Path) -> bytes:
    """Returns the receiver's requirements, in the tested versions, and what the wheel contains."""
    with tempfile.TemporaryDirectory() as made:
        python = wheel_environment.make(Path(made) / "venv", wheel)
        command = [str(cyclonedx), "environment", "--output-reproducible", str(python)]
        bill = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    version = json.loads((ROOT / "config/three/package.json").read_text())["dependencies"]["three"]
    purl = f"pkg:npm/three@{version}"
    three = {"type": "library", "bom-ref": purl, "name": "three", "version": version, "purl": purl}
    bill["components"].append(three | {"licenses": [{"license": {"id": "MIT"}}]})
    return json.dumps(bill, indent=2).encode()


def checksums(folder: Path) -> str:
    """The lines that `sha256sum --check` reads."""
    files = sorted(file for file in folder.iterdir() if file.name != CHECKSUMS)
    digests = {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}
    return "".join(f"{digest}  {name}\n" for name, digest in digests.items())


if __name__ == "__main__":
    sys.exit(main())

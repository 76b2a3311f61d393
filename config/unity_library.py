#!/usr/bin/env python3
"""Puts the library of `make aar` into the Unity package, beside a hash of what it was made of.

A git URL installs the package as it is committed, so the library is committed too. --check writes
nothing and exits with 1 when the hash is another: then run `make unity-library` and commit.
"""

import argparse
import hashlib
import shutil
import sys
from pathlib import Path
from xml.etree import ElementTree

from archives import source_files

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "unity_package/Plugins/Android/ml2-sensors.aar"
# Its name begins with a dot, so it is no asset.
INPUTS_HASH = LIBRARY.with_name(".ml2-sensors.aar.inputs")
INPUTS = [
    "pom.xml",
    *(f"ml2-sensors-aar/{name}" for name in ("pom.xml", "src/main", "aar")),
    *(f"native/{name}" for name in ("device", "generated", "jni", "openxr", "sdk", "sources")),
]


def inputs_hash(root: Path = ROOT) -> str:
    """SHA-256 over names and contents of the sources, as they are now, committed or not."""
    digest = hashlib.sha256()
    for name, content in source_files(root, *INPUTS).items():
        digest.update(f"{hashlib.sha256(content).hexdigest()}  {name}\n".encode())
    return digest.hexdigest()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    if parser.parse_args().check:
        return check()
    version = ElementTree.parse(ROOT / "pom.xml").findtext(".//{*}revision")
    LIBRARY.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(ROOT / f"build/aar/ml2-sensors-unity-{version}.aar", LIBRARY)
    INPUTS_HASH.write_text(inputs_hash() + "\n", "utf-8")
    print(f"wrote {LIBRARY.relative_to(ROOT)}")
    return 0


def check() -> int:
    if LIBRARY.exists() and INPUTS_HASH.read_text("utf-8").strip() == inputs_hash():
        return 0
    print(f"{LIBRARY.relative_to(ROOT)} is stale: run make unity-library", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())

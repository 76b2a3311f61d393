#!/usr/bin/env python3
"""Packs unity_package/ as the Unity Package Manager takes it: build/unity/NAME-VERSION.tgz.

The layout is npm's, everything below package/. Equal contents make equal bytes.
"""

import gzip
import io
import json
import subprocess
import sys
import tarfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "unity_package"
# Only of use in this repository.
LEFT_OUT = ("Api~/", "Tests/Mono~/", "Tests/StandIns~/", "Plugins/Android/.")
# The same in every archive: npm's date.
MODIFIED_S = 499162500


def main() -> int:
    about = json.loads((PACKAGE / "package.json").read_text("utf-8"))
    output = ROOT / "build/unity" / f"{about['name']}-{about['version']}.tgz"
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_bytes(tarball(PACKAGE, contents()))
    print(f"wrote {output.relative_to(ROOT)}")
    return 0


def contents() -> list[str]:
    """Files of the package, relative to it, that git has or would add."""
    command = ["git", "ls-files", "-co", "--exclude-standard", "-z"]
    listed = subprocess.run(command, cwd=PACKAGE, check=True, capture_output=True, text=True).stdout
    names = sorted(set(filter(None, listed.split("\0"))))
    return [name for name in names if not name.startswith(LEFT_OUT) and (PACKAGE / name).is_file()]


def tarball(folder: Path, names: list[str]) -> bytes:
    packed = io.BytesIO()
    with (
        gzip.GzipFile(fileobj=packed, mode="wb", filename="", mtime=0) as zipped,
        tarfile.open(fileobj=zipped, mode="w", format=tarfile.PAX_FORMAT) as archive,
    ):
        for name in names:
            content = (folder / name).read_bytes()
            entry = tarfile.TarInfo(f"package/{name}")
            entry.size = len(content)
            entry.mtime = MODIFIED_S
            entry.mode = 0o644
            archive.addfile(entry, io.BytesIO(content))
    return packed.getvalue()


if __name__ == "__main__":
    sys.exit(main())

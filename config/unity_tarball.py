#!/usr/bin/env python3
"""Packs unity_package/ as the Unity Package Manager takes it: build/unity/NAME-VERSION.tgz.

The layout is npm's, everything below package/. The library that `make aar` packed is put into
unity_package first, where git ignores it, so that a Unity project can also take the package from
that folder. Equal contents make equal bytes.
"""

import json
import sys
from pathlib import Path

from archives import source_files, tar_gz

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "unity_package"
LIBRARY = "Plugins/Android/ml2-sensors.aar"
# Only of use in this repository.
LEFT_OUT = ("Api~/", "Tests/Mono~/", "Tests/Stubs~/")


def main() -> int:
    about = json.loads((PACKAGE / "package.json").read_text("utf-8"))
    library = (ROOT / f"build/aar/ml2-sensors-unity-{about['version']}.aar").read_bytes()
    (PACKAGE / LIBRARY).write_bytes(library)
    sources = source_files(PACKAGE).items()
    files = {name: content for name, content in sources if not name.startswith(LEFT_OUT)}
    files[LIBRARY] = library
    output = ROOT / "build/unity" / f"{about['name']}-{about['version']}.tgz"
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_bytes(tar_gz({f"package/{name}": content for name, content in files.items()}))
    print(f"wrote {output.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Packs unity_package/ as the Unity Package Manager takes it: build/unity/NAME-VERSION.tgz.

The layout is npm's, everything below package/. Equal contents make equal bytes.
"""

import json
import sys
from pathlib import Path

from archives import source_files, tar_gz

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "unity_package"
# Only of use in this repository.
LEFT_OUT = ("Api~/", "Tests/Mono~/", "Tests/Stubs~/", "Plugins/Android/.")


def main() -> int:
    about = json.loads((PACKAGE / "package.json").read_text("utf-8"))
    output = ROOT / "build/unity" / f"{about['name']}-{about['version']}.tgz"
    output.parent.mkdir(parents=True, exist_ok=True)
    files = source_files(PACKAGE).items()
    output.write_bytes(
        tar_gz({f"package/{name}": it for name, it in files if not name.startswith(LEFT_OUT)})
    )
    print(f"wrote {output.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Writes what others need of config/streams.yaml, ROS 2, tests, and the version in the POM.

--check writes nothing and exits with 1 when a file is not what would be written.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "host_receiver"))

from c_table import c_table  # noqa: E402
from configuration_page import configuration_page  # noqa: E402
from csharp_messages import csharp_messages  # noqa: E402
from csharp_table import csharp_table  # noqa: E402
from kotlin_table import kotlin_table  # noqa: E402
from message_definitions import message_definitions  # noqa: E402
from ml2_receiver.errors import TableError  # noqa: E402
from ml2_receiver.table.reader import load_table  # noqa: E402
from sensor_table import with_sensor_table  # noqa: E402
from tried_table import with_tried_table  # noqa: E402
from type_hashes import type_hashes  # noqa: E402
from unity_metas import unity_metas  # noqa: E402

KOTLIN = ROOT / "ml2-sensors-aar/src/main/kotlin/dev/ml2sensors"
PYTHON = ROOT / "host_receiver/ml2_receiver"
UNITY = ROOT / "unity_package"
README, SECURITY = ROOT / "README.md", ROOT / "SECURITY.md"

PYTHON_VERSION = """# Generated from pom.xml by config/generate.py.
VERSION = "{}"
"""
KOTLIN_VERSION = """package dev.ml2sensors

/** Of this library; generated from pom.xml by config/generate.py. */
public object Version {{
    /** MAJOR.MINOR.PATCH. */
    public const val NAME: String = "{}"
}}
"""


def outputs() -> Iterator[tuple[Path, str]]:
    table = load_table()
    yield KOTLIN / "table/generated/StreamTable.kt", kotlin_table(table)
    yield ROOT / "native/generated/ml2s_streams.h", c_table(table)
    yield UNITY / "Runtime/Table/Generated/StreamTable.cs", csharp_table(table)
    yield UNITY / "Runtime/Messages/Generated/Messages.cs", csharp_messages(table)
    yield ROOT / "docs/configuration.md", configuration_page(table)
    yield README, with_sensor_table(README.read_text("utf-8"), table)
    if SECURITY.exists():  # the tests of this script copy what the other tables need alone
        security = SECURITY.read_text("utf-8")
        yield SECURITY, with_tried_table(security, ROOT / "host_receiver/test")

    version = ElementTree.parse(ROOT / "pom.xml").findtext(".//{*}revision")
    yield PYTHON / "generated/__init__.py", ""
    yield PYTHON / "data/message_definitions.json", message_definitions(table)
    yield PYTHON / "generated/type_hashes.py", type_hashes()
    yield PYTHON / "generated/version.py", PYTHON_VERSION.format(version)
    yield KOTLIN / "generated/Version.kt", KOTLIN_VERSION.format(version)
    yield from unity_metas(UNITY)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    check = parser.parse_args().check
    try:
        stale = [(file, text) for file, text in outputs() if not is_current(file, text)]
    except TableError as error:
        sys.exit(f"config/streams.yaml: {error}")
    for file, text in stale:
        name = file.relative_to(ROOT)
        if check:
            print(f"{name} is stale: run config/generate.py", file=sys.stderr)
        else:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, "utf-8")
            print(f"wrote {name}")
    return 1 if check and stale else 0


def is_current(file: Path, text: str) -> bool:
    return file.exists() and file.read_text("utf-8") == text


if __name__ == "__main__":
    sys.exit(main())

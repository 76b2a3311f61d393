"""An app that uses the package, on the simulated device: the very bytes that the package holds."""

import json
import os
import re
import time
from pathlib import Path

import pytest

from document import blocks, without_spacing
from toolchain import ROOT, Package, java, kotlinc

NATIVE = ROOT / "build" / "native"
# The folders of bionic's library names, and of the vendor's library.
LIBRARY_PATH = os.pathsep.join([str(NATIVE / "linux"), str(NATIVE / "host" / "sim")])
CAMERAS = {
    "world_center": "1016 x 1016",
    "world_left": "1016 x 1016",
    "world_right": "1016 x 1016",
    "depth": "544 x 480",
    "infra": "544 x 480",
    "eye_nasal_left": "400 x 400",
    "eye_nasal_right": "400 x 400",
    "eye_temple_left": "400 x 400",
    "eye_temple_right": "400 x 400",
}
ON_ROS = blocks((ROOT / "docs/ros_to_headset.md").read_text(), "kotlin")


@pytest.fixture(autouse=True)
def simulated_device(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LD_LIBRARY_PATH", LIBRARY_PATH)


def device_library(package: Package) -> Path:
    return package.folder / "jni" / "x86_64" / "libml2sensors.so"


def test_an_app_collects_a_frame_of_every_source(library: Package, sample: Path) -> None:
    class_path = [sample, library.classes, *library.libraries]
    main = "dev.ml2sensors.sample.MainKt"
    printed = java(class_path, "-Xcheck:jni", main, device_library(library))
    assert "WARNING" not in printed
    lines = dict(line.split(": ", 1) for line in printed.splitlines())
    for stream, size in CAMERAS.items():
        assert re.fullmatch(rf"{size}, mean byte [1-9]\d*", lines[stream]), lines[stream]
    assert lines["head_pose"].startswith("at Vector3(")


def test_the_examples_of_the_readme_were_compiled(sample: Path) -> None:
    library = ROOT / "ml2-sensors-aar"
    source = library / "sample/src/main/kotlin/dev/ml2sensors/sample/ReadmeExamples.kt"
    compiled = without_spacing(source.read_text())
    examples = [
        text
        for text in blocks((library / "README.md").read_text(), "kotlin")
        if ".gradle.kts" not in text
    ]
    assert len(examples) == 5
    assert [text for text in examples if without_spacing(text) not in compiled] == []


@pytest.mark.parametrize("number", range(len(ON_ROS)))
def test_a_file_of_the_page_on_ros_compiles(number: int, library: Package, tmp_path: Path) -> None:
    source = tmp_path / "Example.kt"
    source.write_text(ON_ROS[number])
    kotlinc(tmp_path / "example.jar", source, [library.classes, *library.libraries])


def test_the_unity_package_works_with_nothing_beside_it(unity: Package) -> None:
    """Native methods, and serialization that was relocated, on bytes of the conformance vectors."""
    program = Path(__file__).parent / "UnityApp.java"
    now, header = java([unity.classes], program, device_library(unity)).splitlines()
    assert 0 < int(now) <= time.clock_gettime_ns(time.CLOCK_BOOTTIME)
    vectors = ROOT / "tests" / "conformance" / "vectors" / "cdr" / "messages.json"
    (piece,) = json.loads(vectors.read_text())["Header"]["bytes"]
    assert header == piece["hex"].replace(" ", "")

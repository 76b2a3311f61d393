"""An app that uses the package, on the simulated device: the very bytes that the package holds."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from toolchain import ROOT, Package, java

NATIVE = ROOT / "build" / "native"
# Where the loader finds bionic's library names, and the vendor's library.
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


def test_an_app_collects_a_frame_of_every_source(
    library: Package, sample: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LD_LIBRARY_PATH", LIBRARY_PATH)
    device_library = library.folder / "jni" / "x86_64" / "libml2sensors.so"
    class_path = [sample, library.classes, *library.libraries]
    printed = java(class_path, "-Xcheck:jni", "dev.ml2sensors.sample.MainKt", device_library)
    assert "WARNING" not in printed
    lines = dict(line.split(": ", 1) for line in printed.splitlines())
    for stream, size in CAMERAS.items():
        assert re.fullmatch(rf"{size}, mean byte [1-9]\d*", lines[stream]), lines[stream]
    assert lines["head_pose"].startswith("at Vector3(")

"""The simulated headset as a test artefact: a program with only its jar on the class path."""

import filecmp
import os
import re
import shutil
import zipfile
from hashlib import sha256
from pathlib import Path

import pytest

from document import blocks, without_spacing
from toolchain import PACKAGES, ROOT, Package, kotlinc, maven_property, run

SIMULATOR = ROOT / "ml2-sensors-aar" / "simulator"
SAMPLE = SIMULATOR / "sample" / "Main.kt"
NAME = f"ml2-headset-{maven_property('revision')}"
JAR = SIMULATOR / "target" / f"{NAME}.jar"


@pytest.fixture(scope="session")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The example, compiled."""
    jar = tmp_path_factory.mktemp("program") / "program.jar"
    kotlinc(jar, SAMPLE, class_path=[JAR, *(SIMULATOR / "target" / "lib").glob("*.jar")])
    return jar


def test_a_program_opens_it_with_an_empty_environment(program: Path, tmp_path: Path) -> None:
    java = shutil.which("java")
    assert java
    class_path = f"{JAR}{os.pathsep}{program}"
    options = ["-Xcheck:jni", f"-Djava.io.tmpdir={tmp_path}", "-cp", class_path]
    printed = run("env", "-i", java, *options, "dev.ml2sensors.sample.MainKt")
    assert len(re.findall(r"1016x1016 at \d+, pose Transform\(", printed)) == 3, printed
    assert not re.search("WARNING|FATAL ERROR", printed), "of the JVM, which checks every JNI call"
    assert list(tmp_path.iterdir()) == [], "what was unpacked is gone"


def test_it_runs_the_very_library_of_the_package(library: Package) -> None:
    packaged = library.folder / "jni" / "x86_64" / "libml2sensors.so"
    with zipfile.ZipFile(JAR) as archive:
        bundled = archive.read("dev/ml2sensors/simulator/native/libml2sensors.so")
    assert sha256(bundled).digest() == sha256(packaged.read_bytes()).digest()


def test_the_repository_holds_it_where_gradle_looks() -> None:
    folder = PACKAGES / "repository" / "dev" / "ml2sensors" / "ml2-headset"
    pom = folder / maven_property("revision") / f"{NAME}.pom"
    assert filecmp.cmp(pom.with_suffix(".jar"), JAR, shallow=False)
    assert "${" not in pom.read_text()


def test_the_example_of_the_readme_was_compiled() -> None:
    example = next(
        text
        for text in blocks((SIMULATOR / "README.md").read_text(), "kotlin")
        if "SimulatedHeadset.open" in text
    )
    assert without_spacing(example) in without_spacing(SAMPLE.read_text())

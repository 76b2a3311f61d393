"""D8 and R8 take the packages with nothing to say about them; R8 the library in `make apk`."""

import re
from pathlib import Path

from class_file import read_classes
from toolchain import Package, d8, r8, run


def dex_classes(folder: Path) -> set[str]:
    """Their names as in class files."""
    dumped = run("dexdump", folder / "classes.dex")
    return set(re.findall(r"Class descriptor  : 'L(\S+);'", dumped))


def complaints(output: str) -> list[str]:
    """All but the notes on rules in the jars of others that find nothing to keep."""
    where = r"Info in \S+:META-INF/\S+ at line .*:\n"
    what = r"Proguard configuration rule does not match anything: `[^`]*`\n"
    return re.sub(where + what, "", output).splitlines()


def test_d8_translates_every_class(package: Package, tmp_path: Path) -> None:
    assert complaints(d8(tmp_path, package.classes, libraries=package.libraries)) == []
    assert read_classes(package.classes).keys() <= dex_classes(tmp_path)


def test_r8_shrinks_an_app_that_uses_the_unity_package(unity: Package, tmp_path: Path) -> None:
    """A Unity project calls by reflection; rules keep the called classes."""
    rules = tmp_path / "app.pro"
    rules.write_text("-keep class dev.ml2sensors.stream.Ml2Streamer { public *; }")
    output = r8(tmp_path, "--pg-conf", rules, "--pg-conf", unity.rules, unity.classes)
    assert complaints(output) == []
    assert named_by_native_code(unity) <= dex_classes(tmp_path)


def named_by_native_code(package: Package) -> set[str]:
    library = (package.folder / "jni" / "x86_64" / "libml2sensors.so").read_bytes()
    return {name.decode() for name in re.findall(rb"dev/ml2sensors/[\w/$]+\w", library)}

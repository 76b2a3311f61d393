"""Checks that the packages use nothing that Android 10 lacks.

R8 cannot tell: it is given the whole platform with its hidden API, and a newer java.*.
"""

from functools import cache
from pathlib import Path

import pytest

from class_file import read_classes
from platform_api import allowed_api, has_api, missing_api, public_api
from toolchain import MIN_API, ROOT, Package, d8, jar, maven_property, run

APP = ROOT / f"ml2-sensors-aar/app/target/ml2-sensors-app-{maven_property('revision')}.jar"

_public_api = cache(public_api)

# In the libraries that the Unity package takes in.
_OF_THE_LIBRARIES = {
    # Both ask Class.forName before.
    "java/lang/ClassValue",
    "java/lang/ClassValue.get (Ljava/lang/Class;)Ljava/lang/Object;",
    # Java 8, in Android since 26.
    "java/lang/Integer.compareUnsigned (II)I",
    "java/lang/Integer.divideUnsigned (II)I",
    "java/lang/Integer.toUnsignedString (I)Ljava/lang/String;",
    "java/lang/Long.compareUnsigned (JJ)I",
    "java/lang/Long.divideUnsigned (JJ)J",
    "java/lang/Long.toUnsignedString (J)Ljava/lang/String;",
}


def missing(classes: Path, libraries: tuple[Path, ...], folder: Path) -> set[str]:
    """Returns the called members that the public API lacks, after D8's rewriting."""
    desugared = folder / "desugared.jar"
    d8(desugared, "--classfile", classes, libraries=libraries)
    return missing_api(read_classes(desugared), read_classes(*libraries), _public_api())


@pytest.fixture(scope="module")
def missing_for_library(library: Package, tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    return missing(library.classes, library.libraries, tmp_path_factory.mktemp("library"))


@pytest.fixture(scope="module")
def missing_for_app(library: Package, tmp_path_factory: pytest.TempPathFactory) -> set[str]:
    beside = (library.classes, *library.libraries)
    return missing(APP, beside, tmp_path_factory.mktemp("app"))


def test_the_library_uses_only_public_api_up_to_29(missing_for_library: set[str]) -> None:
    assert missing_for_library - {row.name for row in allowed_api()} == set()


def test_the_unity_package_uses_no_more(unity: Package, tmp_path: Path) -> None:
    used = missing(unity.classes, unity.libraries, tmp_path)
    assert used - {row.name for row in allowed_api()} - _OF_THE_LIBRARIES == set()


def test_the_app_uses_no_more(missing_for_app: set[str]) -> None:
    assert missing_for_app - {row.name for row in allowed_api()} == set()


def test_what_is_allowed_is_used_and_not_newer_than_29(
    missing_for_library: set[str], missing_for_app: set[str]
) -> None:
    allowed = allowed_api()
    assert {row.name for row in allowed} <= missing_for_library | missing_for_app
    assert [row for row in allowed if not 24 < row.level <= int(MIN_API) or not row.reason] == []


def test_what_is_allowed_of_android_is_in_android_10() -> None:
    android_10 = read_classes(jar("android-all"))
    names = [row.name for row in allowed_api() if row.name.startswith("android/")]
    assert [name for name in names if not has_api(android_10, name)] == []


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("java.util.List.copyOf(new java.util.ArrayList<>())", set()),  # D8 supplies it
        ('"".lines()', {"java/lang/String.lines ()Ljava/util/stream/Stream;"}),  # API 34
    ],
)
def test_a_newer_call_is_found(call: str, expected: set[str], tmp_path: Path) -> None:
    source = tmp_path / "Newer.java"
    source.write_text(f"class Newer {{ Object call() {{ return {call}; }} }}")
    run("javac", "--release", "11", "-d", tmp_path, source)
    run("jar", "--create", "--file", tmp_path / "newer.jar", "-C", tmp_path, "Newer.class")
    assert missing(tmp_path / "newer.jar", (), tmp_path) == expected

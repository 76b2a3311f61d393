"""Contents of the packages; the same sources always make the same packages."""

import filecmp
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

from class_file import read_classes
from toolchain import ELSEWHERE, PACKAGES, ROOT, Package, maven_property, run

FRAMEWORK = Path("/usr/share/android-framework-res/framework-res.apk")
ENTRIES = [
    "AndroidManifest.xml",
    "classes.jar",
    "R.txt",
    "proguard.txt",
    "baseline-prof.txt",
    "jni/x86_64/libml2sensors.so",
    "META-INF/com/android/build/gradle/aar-metadata.properties",
]
VERSION = maven_property("revision")


def test_a_package_holds_exactly_these_files(package: Package) -> None:
    with zipfile.ZipFile(package.file) as archive:
        assert archive.namelist() == ENTRIES
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_the_baseline_profile_names_packages_that_exist(library: Package) -> None:
    lines = (library.folder / "baseline-prof.txt").read_text().splitlines()
    rules = [line for line in lines if not line.startswith("#")]
    packages = [
        re.fullmatch(r"H?S?P?L([a-z0-9/]+)/\*\*(?:->\*\*\(\*\*\)\*\*|;)", it) for it in rules
    ]
    classes = [name for jar in (library.classes, *library.libraries) for name in read_classes(jar)]
    for rule, package in zip(rules, packages, strict=True):
        assert package, rule
        assert any(name.startswith(f"{package[1]}/") for name in classes), rule


def test_aapt_reads_the_manifest(package: Package, tmp_path: Path) -> None:
    application = tmp_path / "dummy.apk"
    manifest = package.folder / "AndroidManifest.xml"
    run("aapt", "package", "-M", manifest, "-I", FRAMEWORK, "-F", application)
    badging = run("aapt", "dump", "badging", application).splitlines()
    assert badging[0].startswith("package: name='dev.ml2sensors' ")
    assert "sdkVersion:'29'" in badging
    assert run("aapt", "dump", "permissions", application).splitlines() == [
        "package: dev.ml2sensors",
        "uses-permission: name='android.permission.INTERNET'",
        "uses-permission: name='android.permission.ACCESS_NETWORK_STATE'",
        "uses-permission: name='android.permission.ACCESS_WIFI_STATE'",
        "uses-permission: name='android.permission.CHANGE_WIFI_MULTICAST_STATE'",
    ]


def test_the_library_holds_its_own_classes_and_no_others(library: Package) -> None:
    with zipfile.ZipFile(library.classes) as archive:
        strange = [
            name
            for name in archive.namelist()
            if not (name.startswith("dev/ml2sensors/") and name.endswith(".class"))
        ]
    assert strange == ["META-INF/ml2-sensors.kotlin_module"]


def test_the_unity_package_refers_to_nothing_outside_itself(unity: Package) -> None:
    classes = read_classes(unity.classes)
    assert {name for name in classes if not name.startswith("dev/ml2sensors/")} == set()
    platform = ("java/", "javax/", "android/", "sun/misc/Unsafe", "dalvik/")
    referred = {name for file in classes.values() for name in file.classes if len(name) > 1}
    assert {name for name in referred - classes.keys() if not name.startswith(platform)} == set()


def test_the_unity_package_keeps_every_class_of_the_library(
    library: Package, unity: Package
) -> None:
    assert read_classes(library.classes).keys() <= read_classes(unity.classes).keys()


def test_sources_and_documentation_lie_beside_the_library() -> None:
    with zipfile.ZipFile(PACKAGES / f"ml2-sensors-{VERSION}-sources.jar") as archive:
        assert "dev/ml2sensors/source/Headset.kt" in archive.namelist()
    with zipfile.ZipFile(PACKAGES / f"ml2-sensors-{VERSION}-javadoc.jar") as archive:
        assert "ml2-sensors/dev.ml2sensors.source/-headset/index.html" in archive.namelist()


def test_the_repository_holds_the_library_where_gradle_looks() -> None:
    folder = PACKAGES / "repository" / "dev" / "ml2sensors" / "ml2-sensors" / VERSION
    for ending in [".aar", ".pom", "-sources.jar", "-javadoc.jar"]:
        name = f"ml2-sensors-{VERSION}{ending}"
        assert filecmp.cmp(folder / name, PACKAGES / name, shallow=False)


def test_the_same_sources_make_the_same_bytes_elsewhere(tmp_path: Path) -> None:
    """Built once more from nothing: in another folder, time zone, language and encoding, later."""
    copied = [".mvn", "pom.xml", "ml2-sensors-aar", "build/native/device"]
    for name in copied:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).is_dir():
            without = shutil.ignore_patterns("target")
            shutil.copytree(ROOT / name, tmp_path / name, ignore=without)
        else:
            shutil.copy(ROOT / name, tmp_path / name)
    alone = ["-DskipTests", "-Dphase.test-compile=none", "-Ddokka.skip"]
    goals = ["package", *alone, "-pl", "ml2-sensors-aar/aar", "-am"]
    subprocess.run(["mvn", "--offline", "--quiet", *ELSEWHERE, *goals], cwd=tmp_path, check=True)
    for name in ["ml2-sensors", "ml2-sensors-unity"]:
        again = tmp_path / "build" / "aar" / f"{name}-{VERSION}.aar"
        assert filecmp.cmp(again, PACKAGES / again.name, shallow=False)


def test_the_library_is_the_one_that_was_linked(package: Package) -> None:
    packed = package.folder / "jni" / "x86_64" / "libml2sensors.so"
    linked = ROOT / "build" / "native" / "device" / "libml2sensors.so"
    assert filecmp.cmp(packed, linked, shallow=False)


def test_the_library_needs_and_shows_nothing_unexpected() -> None:
    """Libraries needed, symbols imported and exported."""
    assert run(ROOT / "native" / "device" / "check.sh") == ""

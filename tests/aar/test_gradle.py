"""The Gradle files name what Maven builds with. No Gradle is run on them."""

from __future__ import annotations

import re
import tomllib

import pytest

from apk import APK
from toolchain import MIN_API, ROOT, Package, maven_property, run

CATALOGUE = tomllib.loads((ROOT / "gradle" / "libs.versions.toml").read_text())
SCRIPT = (ROOT / "ml2-sensors-aar" / "build.gradle.kts").read_text()
APP_SCRIPT = (ROOT / "ml2-sensors-aar" / "app" / "build.gradle.kts").read_text()


@pytest.mark.parametrize("name", sorted(CATALOGUE["versions"].keys() - {"agp", "openxr"}))
def test_a_version_is_that_of_the_pom(name: str) -> None:
    assert CATALOGUE["versions"][name] == maven_property(f"{name}.version")


def test_every_alias_is_in_the_catalogue() -> None:
    scripts = SCRIPT + APP_SCRIPT + (ROOT / "build.gradle.kts").read_text()
    used = re.findall(r"\blibs\.(plugins\.)?([\w.]+)\)", scripts)
    plugins = {name.replace(".", "-") for is_plugin, name in used if is_plugin}
    libraries = {name.replace(".", "-") for is_plugin, name in used if not is_plugin}
    assert plugins == CATALOGUE["plugins"].keys()
    assert libraries == CATALOGUE["libraries"].keys()


def test_package_and_levels_are_those_of_the_aar(library: Package) -> None:
    manifest = (library.folder / "AndroidManifest.xml").read_text()
    assert re.findall(r'namespace = "(.*)"', SCRIPT) == re.findall(r'package="(.*?)"', manifest)
    assert re.findall(r"minSdk = (.*)", SCRIPT) == [MIN_API]
    assert re.findall(r'minSdkVersion="(.*?)"', manifest) == [MIN_API]


def test_package_levels_and_version_are_those_of_the_app() -> None:
    badging = run("aapt", "dump", "badging", APK)
    for setting, printed in [
        ('namespace = "(.*)"', "package: name='(.*?)'"),
        ('versionName = "(.*)"', "versionName='(.*?)'"),
        ("versionCode = (.*)", "versionCode='(.*?)'"),
        ("minSdk = (.*)", "sdkVersion:'(.*)'"),
        ("targetSdk = (.*)", "targetSdkVersion:'(.*)'"),
    ]:
        assert re.findall(setting, APP_SCRIPT)[0] in re.findall(printed, badging), setting


def test_the_files_it_names_exist() -> None:
    named = re.findall(r'(?:file|consumerProguardFiles)\("(.*)"\)', SCRIPT)
    assert len(named) == 2
    for name in named:
        assert (ROOT / "ml2-sensors-aar" / name).is_file(), name

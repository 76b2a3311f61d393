"""The Gradle files compile against the interfaces of Gradle and of its plugins.

gradlew installs only the Gradle that it names. No Gradle is run.
"""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import zipfile
from functools import cache
from pathlib import Path

import pytest

from document import blocks
from test_gradle import CATALOGUE
from toolchain import ROOT, java_command, maven_property, run

DSL = ROOT / "tests" / "aar" / "gradle"
CLASS_PATH = ROOT / "build" / "gradle-scripts.classpath"
# Each script, and what Gradle makes of `this` in it.
SCRIPTS = {
    "settings.gradle.kts": "org.gradle.api.initialization.Settings",
    "build.gradle.kts": "org.gradle.api.Project",
    "ml2-sensors-aar/build.gradle.kts": "LibraryScript",
    "ml2-sensors-aar/app/build.gradle.kts": "ApplicationScript",
}
# The same of the blocks that README.md has for a new app, by the file that each begins with.
DOCUMENTED = {
    "settings.gradle.kts": "org.gradle.api.initialization.Settings",
    "build.gradle.kts": "org.gradle.api.Project",
    "app/build.gradle.kts": "ApplicationScript",
}
# What Gradle's Kotlin DSL imports by itself, and the compiler plugins that it uses.
IMPORTS = ["org.gradle.api.*", "org.gradle.api.initialization.resolve.*"]
PLUGINS = {
    "samWithReceiver:annotation": "org.gradle.api.HasImplicitReceiver",
    "assignment:annotation": "org.gradle.api.SupportsKotlinAssignmentOverloading",
}


@cache
def class_path() -> list[Path]:
    versions = [
        f"-Dagp.version={CATALOGUE['versions']['agp']}",
        f"-Dkotlin.version={maven_property('kotlin.version')}",
    ]
    output = f"-Dmdep.outputFile={CLASS_PATH}"
    run("mvn", "-q", "-f", DSL, "dependency:build-classpath", output, *versions)
    return [Path(it) for it in CLASS_PATH.read_text().split(os.pathsep) if it.endswith(".jar")]


def catalogue() -> str:
    """The accessors that Gradle generates of the catalogue of versions."""

    def members(table: str, type: str) -> str:
        names = [re.sub(r"-(\w)", lambda it: "." + it[1], name) for name in CATALOGUE[table]]
        nested: dict[str, list[str]] = {}
        for name in names:
            group, _, last = name.rpartition(".")
            nested.setdefault(group, []).append(f"val {last}: Provider<{type}> get() = TODO()")
        return "\n".join(
            "\n".join(values) if not group else f"object {group} {{ {'; '.join(values)} }}"
            for group, values in nested.items()
        )

    return f"""
        import org.gradle.api.artifacts.MinimalExternalModuleDependency
        import org.gradle.api.provider.Provider
        import org.gradle.plugin.use.PluginDependency
        object libs {{
            {members("libraries", "MinimalExternalModuleDependency")}
            object plugins {{ {members("plugins", "PluginDependency")} }}
        }}
    """


def as_function(name: str, text: str, receiver: str) -> str:
    imports = re.findall(r"^import .*$", text, re.MULTILINE) + [f"import {it}" for it in IMPORTS]
    body = re.sub(r"^import .*$", "", text, flags=re.MULTILINE)
    return "\n".join([*imports, f"fun {receiver}.{name}() {{", body, "}"])


def compile_scripts(
    folder: Path, scripts: dict[str, str], receivers: dict[str, str] = SCRIPTS
) -> subprocess.CompletedProcess[str]:
    sources = {"Libs.kt": catalogue()}
    for number, (path, text) in enumerate(scripts.items()):
        sources[f"Script{number}.kt"] = as_function(f"script{number}", text, receivers[path])
    for name, text in sources.items():
        (folder / name).write_text(text)
    jars = os.pathsep.join(map(str, class_path()))
    plugins = [
        f"-Xplugin={jar}"
        for jar in class_path()
        if jar.name.startswith(("kotlin-sam-with-receiver", "kotlin-assignment"))
    ]
    options = [
        argument
        for option, annotation in PLUGINS.items()
        for argument in ("-P", f"plugin:org.jetbrains.kotlin.{option}={annotation}")
    ]
    arguments = ["-no-stdlib", "-cp", jars, "-d", str(folder / "classes"), *plugins, *options]
    files = [str(DSL / "KotlinDsl.kt"), *(str(folder / name) for name in sources)]
    compiler = "org.jetbrains.kotlin.cli.jvm.K2JVMCompiler"
    command = java_command(class_path(), compiler, *arguments, *files)
    return subprocess.run(command, check=False, capture_output=True, text=True)


def scripts() -> dict[str, str]:
    return {path: (ROOT / path).read_text() for path in SCRIPTS}


def test_the_scripts_compile(tmp_path: Path) -> None:
    result = compile_scripts(tmp_path, scripts())
    assert result.returncode == 0, result.stderr


def test_a_setting_that_the_android_plugin_does_not_have_is_found(tmp_path: Path) -> None:
    library = "ml2-sensors-aar/build.gradle.kts"
    wrong = scripts()[library].replace("compileSdk =", "compilesSdk =")
    result = compile_scripts(tmp_path, {library: wrong})
    assert result.returncode != 0
    assert "compilesSdk" in result.stderr


def test_what_a_new_app_pastes_compiles(tmp_path: Path) -> None:
    readme = (ROOT / "ml2-sensors-aar/README.md").read_text()
    pasted = {
        begins[1]: text
        for text in blocks(readme, "kotlin")
        if (begins := re.match(r"// (\S+\.gradle\.kts)\b", text))
    }
    assert pasted.keys() == DOCUMENTED.keys()
    result = compile_scripts(tmp_path, pasted, DOCUMENTED)
    assert result.returncode == 0, result.stderr


def distribution(folder: Path) -> Path:
    archive = folder / "gradle-bin.zip"
    with zipfile.ZipFile(archive, "w") as file:
        entry = zipfile.ZipInfo("gradle-8.13/bin/gradle")
        entry.external_attr = 0o755 << 16
        file.writestr(entry, '#!/bin/sh\necho "gradle here: $*"\n')
    return archive


@pytest.mark.parametrize("is_right", [True, False])
def test_gradlew_runs_only_the_gradle_that_has_the_named_checksum(
    tmp_path: Path, is_right: bool
) -> None:
    archive = distribution(tmp_path)
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    properties = tmp_path / "gradle" / "wrapper" / "gradle-wrapper.properties"
    properties.parent.mkdir(parents=True)
    url = archive.as_uri().replace(":", "\\:")
    named = digest if is_right else digest[::-1]
    properties.write_text(f"distributionUrl={url}\ndistributionSha256Sum={named}\n")
    gradlew = tmp_path / "gradlew"
    gradlew.write_bytes((ROOT / "gradlew").read_bytes())
    home = tmp_path / "home"
    environment = os.environ | {"GRADLE_USER_HOME": str(home)}
    command = ["bash", str(gradlew), ":ml2-sensors-aar:assembleRelease"]
    result = subprocess.run(command, check=False, env=environment, capture_output=True, text=True)
    if is_right:
        assert result.returncode == 0, result.stderr
        assert "gradle here: :ml2-sensors-aar:assembleRelease" in result.stdout
    else:
        assert result.returncode == 1
        assert "nothing was installed" in result.stderr
        assert [it for it in home.rglob("*") if it.is_file()] == []


def test_the_real_properties_name_gradle_with_a_checksum() -> None:
    properties = (ROOT / "gradle" / "wrapper" / "gradle-wrapper.properties").read_text()
    assert re.search(r"^distributionUrl=https\\://.*/gradle-8\.13-bin\.zip$", properties, re.M)
    assert re.search(r"^distributionSha256Sum=[0-9a-f]{64}$", properties, re.M)

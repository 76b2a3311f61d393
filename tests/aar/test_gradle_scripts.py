"""The Gradle files that README.md has for a new app compile against Gradle's interfaces.

No Gradle is run.
"""

import os
import re
import subprocess
from functools import cache
from pathlib import Path

from document import blocks
from toolchain import ROOT, java_command, maven_property, run

DSL = ROOT / "tests" / "aar" / "gradle"
CLASS_PATH = ROOT / "build" / "gradle-scripts.classpath"
# The type of `this` in a block, by the file name at its beginning.
RECEIVERS = {
    "settings.gradle.kts": "org.gradle.api.initialization.Settings",
    "build.gradle.kts": "org.gradle.api.Project",
    "app/build.gradle.kts": "org.gradle.api.Project",
}
# The default imports of Gradle's Kotlin DSL, and the compiler plugins that it uses.
IMPORTS = ["org.gradle.api.*", "org.gradle.api.initialization.resolve.*"]
PLUGINS = {
    "samWithReceiver:annotation": "org.gradle.api.HasImplicitReceiver",
    "assignment:annotation": "org.gradle.api.SupportsKotlinAssignmentOverloading",
}


@cache
def class_path() -> list[Path]:
    options = [
        f"-Dkotlin.version={maven_property('kotlin.version')}",
        f"-Dmdep.outputFile={CLASS_PATH}",
    ]
    run("mvn", "-q", "-f", DSL, "dependency:build-classpath", *options)
    return [Path(it) for it in CLASS_PATH.read_text().split(os.pathsep) if it.endswith(".jar")]


def as_function(name: str, text: str, receiver: str) -> str:
    imports = [f"import {it}" for it in IMPORTS]
    return "\n".join([*imports, f"fun {receiver}.{name}() {{", text, "}"])


def compile_scripts(folder: Path, scripts: dict[str, str]) -> subprocess.CompletedProcess[str]:
    files = [DSL / "KotlinDsl.kt"]
    for number, (path, text) in enumerate(scripts.items()):
        files.append(folder / f"Script{number}.kt")
        files[-1].write_text(as_function(f"script{number}", text, RECEIVERS[path]))
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
    compiler = "org.jetbrains.kotlin.cli.jvm.K2JVMCompiler"
    command = java_command(class_path(), compiler, *arguments, *map(str, files))
    return subprocess.run(command, check=False, capture_output=True, text=True)


def pasted() -> dict[str, str]:
    readme = (ROOT / "ml2-sensors-aar/README.md").read_text()
    return {
        begins[1]: text
        for text in blocks(readme, "kotlin")
        if (begins := re.match(r"// (\S+\.gradle\.kts)\b", text))
    }


def test_what_a_new_app_pastes_compiles(tmp_path: Path) -> None:
    assert pasted().keys() == RECEIVERS.keys()
    result = compile_scripts(tmp_path, pasted())
    assert result.returncode == 0, result.stderr


def test_a_setting_that_gradle_does_not_have_is_found(tmp_path: Path) -> None:
    wrong = pasted()["settings.gradle.kts"].replace("repositoriesMode =", "repositoryMode =")
    result = compile_scripts(tmp_path, {"settings.gradle.kts": wrong})
    assert result.returncode != 0
    assert "repositoryMode" in result.stderr

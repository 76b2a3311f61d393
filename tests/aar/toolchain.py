"""The packages under test, and what judges them: the tools of the packages' own Maven module."""

import os
import shutil
import subprocess
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ROOT / "build" / "aar"
MIN_API = "29"
# Options of a Java that builds elsewhere on earth
ELSEWHERE = ["-Duser.timezone=Pacific/Kiritimati", "-Duser.language=tr", "-Dfile.encoding=ASCII"]


@cache
def maven_property(name: str) -> str:
    value = ElementTree.parse(ROOT / "pom.xml").findtext(f"{{*}}properties/{{*}}{name}")
    assert value, f"pom.xml has no property {name}"
    return value


@dataclass(frozen=True)
class Package:
    """A built AAR, the folder it was unpacked to, and the jars it needs beside it."""

    file: Path
    folder: Path
    libraries: tuple[Path, ...]

    @property
    def classes(self) -> Path:
        return self.folder / "classes.jar"

    @property
    def rules(self) -> Path:
        return self.folder / "proguard.txt"


def unpack(name: str, folder: Path, libraries: Iterable[Path]) -> Package:
    file = PACKAGES / f"{name}-{maven_property('revision')}.aar"
    with zipfile.ZipFile(file) as archive:
        archive.extractall(folder)
    return Package(file, folder, tuple(libraries))


@cache
def _class_path() -> tuple[Path, ...]:
    """Returns the class path of the Maven module."""
    listed = (ROOT / "ml2-sensors-aar" / "aar" / "target" / "classpath").read_text()
    return tuple(Path(entry) for entry in listed.split(os.pathsep))


def jar(name: str) -> Path:
    """The one artifact of the class path whose file name is `name`-VERSION."""
    (found,) = [
        path for path in _class_path() if path.name == f"{name}-{path.parent.name}{path.suffix}"
    ]
    return found


def runtime_libraries() -> list[Path]:
    """Returns the library's run-time dependencies, direct and indirect, from its POM."""
    kotlin = ["kotlin-stdlib", "annotations", "kotlinx-coroutines-core-jvm"]
    serialization = ["kotlinx-serialization-json-jvm", "kotlinx-serialization-core-jvm"]
    return [jar(name) for name in kotlin + serialization]


def run(*command: str | Path) -> str:
    """Returns the output of a command, both streams together; raises if it fails."""
    done = subprocess.run(
        command, check=False, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    assert done.returncode == 0, f"{' '.join(map(str, command))}:\n{done.stdout}"
    return done.stdout


def java_command(class_path: Iterable[Path], *arguments: str | Path) -> list[str | Path]:
    # HotSpot's second compiler costs more than it saves programs that live for seconds.
    options = ["-XX:TieredStopAtLevel=1", "-XX:+UseParallelGC"]
    return ["java", *options, "-cp", os.pathsep.join(map(str, class_path)), *arguments]


def java(class_path: Iterable[Path], *arguments: str | Path) -> str:
    return run(*java_command(class_path, *arguments))


def kotlinc(output: Path, sources: Path, class_path: Iterable[Path]) -> None:
    compiler = [path for path in _class_path() if path.suffix == ".jar"]
    classes = os.pathsep.join(map(str, class_path))
    options = ["-no-stdlib", "-no-reflect", "-jvm-target", "11", "-Werror", "-cp", classes]
    options.append(f"-Xplugin={jar('kotlin-serialization-compiler-plugin-embeddable')}")
    main = "org.jetbrains.kotlin.cli.jvm.K2JVMCompiler"
    assert java(compiler, main, *options, "-d", output, sources) == ""


def d8(output: Path, *arguments: str | Path, libraries: Iterable[Path]) -> str:
    """Prints nothing when there is nothing to complain about."""
    return _dexer("D8", output, *arguments, *_each("--classpath", libraries))


def r8(output: Path, *arguments: str | Path) -> str:
    # Files of one name in several jars are for the app's build to merge.
    return _dexer("R8", output, "--no-data-resources", *arguments)


def _dexer(name: str, output: Path, *arguments: str | Path) -> str:
    # Android 10 as the headset has it, without java.*, which the JDK stands in for.
    platform = _each("--lib", [jar("android-all"), _jdk()])
    tool = f"com.android.tools.r8.{name}"
    levels = ["--min-api", MIN_API, "--map-diagnostics", "warning", "error"]
    return java([jar("r8")], tool, *levels, *platform, "--output", output, *arguments)


def _jdk() -> Path:
    command = shutil.which("java")
    assert command, "no java on the PATH: make setup"
    return Path(command).resolve().parents[1]


def _each(option: str, values: Iterable[Path]) -> list[str | Path]:
    return [word for value in values for word in (option, value)]

"""The scripts of the checkout on machines that lack something: what they say."""

import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from document import ROOT, files
from own_environment import MAY_MOUNT_AND_MAKE_NETWORKS
from waiting import LIMIT_S

NOBODY = 65534
is_root = pytest.mark.skipif(
    not MAY_MOUNT_AND_MAKE_NETWORKS, reason="only root can be another user, or mount"
)


@pytest.fixture
def checkout() -> Iterator[Path]:
    """The scripts of set-up in a folder that everybody can write, and `bin` for programs."""
    with TemporaryDirectory() as folder:  # another user cannot enter pytest's
        root = Path(folder)
        for name in ("config", "host_receiver/environment"):
            shutil.copytree(ROOT / name, root / name)
        for name in ("pyproject.toml", "setup.py"):
            shutil.copy(ROOT / "host_receiver" / name, root / "host_receiver")
        (root / "bin").mkdir()
        (root / "home").mkdir()
        for path in (root, *root.rglob("*")):
            path.chmod(0o777)
        yield root


@pytest.fixture
def full_disk(checkout: Path) -> Iterator[Path]:
    """`build` on a disk with 300 kB."""
    build = checkout / "build"
    build.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "full", build], check=True)
    yield build
    subprocess.run(["umount", build], check=True)


@pytest.fixture
def read_only_home(checkout: Path) -> Iterator[Path]:
    home = checkout / "home"
    subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "home", home], check=True)
    yield home
    subprocess.run(["umount", home], check=True)


def program(checkout: Path, name: str, text: str) -> None:
    file = checkout / "bin" / name
    file.write_text(f"#!/bin/sh\n{text}\n")
    file.chmod(0o755)


def run(checkout: Path, *words: str, user: int | None = None) -> tuple[int, list[str]]:
    """The exit code, and the lines of standard error."""
    path = f"{checkout / 'bin'}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        words,
        cwd=checkout,
        env={**os.environ, "PATH": path, "HOME": str(checkout / "home")},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
        user=user,
    )
    return done.returncode, done.stderr.splitlines()


def lack(checkout: Path, package: str, group: str = "receiver") -> None:
    """Makes setup find that a Debian package is missing."""
    with (checkout / "host_receiver/environment/debian-packages.txt").open("a") as table:
        table.write(f"{package} no-such-program {group}\n")


def test_a_script_that_ends_early_says_where_and_of_what(checkout: Path) -> None:
    script = checkout / "script.sh"
    script.write_text("set -euo pipefail\nsource config/errors.sh\nlook() {\n  ls /none\n}\nlook\n")
    code, errors = run(checkout, "bash", "script.sh")
    assert code == 2
    assert "script.sh:4: exit code 2 of: ls /none" in errors


def test_tests_that_failed_are_named_last(checkout: Path) -> None:
    named = (
        "[ERROR] a.Test.b -- Time elapsed: 1 s <<< FAILURE!",
        "FAILED tests/test_a.py::test_b - E",
    )
    lines = "".join(f"  echo '{it}'\n" for it in named)
    program(checkout, "make", f"if test $1 = bad; then\n{lines}  seq 100; exit 1\nfi")
    command = "MAKE=make config/at_a_time.sh 2 bad good"
    code, errors = run(checkout, "bash", "-c", command)
    assert code == 1
    machine = errors.pop(-2)
    assert errors == [*sorted(f"bad | {it}" for it in named), "failed: bad"]
    assert re.fullmatch(r"\S+ free on the disk, load average [\d. ]+", machine)


def test_every_script_says_it() -> None:
    texts = {it: it.read_bytes() for it in files()}
    scripts = {it for it, text in texts.items() if re.match(rb"#!/usr/bin/env (-S .+ )?bash", text)}
    assert {it.name for it in scripts if b"/errors.sh" not in texts[it]} == {
        "ml2-headset",  # becomes another program, as the next
        "ml2-receiver",
        "run.sh",
        "find_python.sh",  # says nothing of the Pythons that do not fit
    }


def test_without_a_network_setup_says_what_to_mend(checkout: Path) -> None:
    lack(checkout, "some-package")
    program(checkout, "apt-get", "echo 'Could not resolve host' >&2; exit 100")
    program(checkout, "sudo", 'shift; exec "$@"')
    code, errors = run(checkout, "host_receiver/environment/setup.sh")
    assert code == 1
    assert "Could not resolve host" in errors
    assert errors[-1].startswith("setup: apt-get cannot read its lists of packages: mend what")


@is_root
def test_maven_says_that_the_disk_is_full(checkout: Path, full_disk: Path) -> None:
    program(checkout, "mvn", "echo '[ERROR] Could not resolve dependencies' >&2; exit 7")
    maven = checkout / "config/kotlin/maven.sh"
    for folder, disks in ((checkout, []), (full_disk, [full_disk])):
        code, errors = run(checkout, "sh", "-c", f"cd {folder} && {maven}")
        assert code == 7
        said = [f"maven: the disk of {it} has 1 MB free; make room, then try again" for it in disks]
        assert errors[1:] == said


def test_only_packages_of_the_asked_groups_are_installed(checkout: Path) -> None:
    for group in ("receiver", "lint", "view"):
        lack(checkout, f"package-of-{group}", group)
    program(checkout, "apt-get", 'echo "apt-get $*" >&2; test "$1" = update')
    program(checkout, "sudo", 'test "$1" = -n && shift; exec "$@"')
    code, errors = run(checkout, "host_receiver/environment/setup.sh", "receiver", "lint")
    assert code == 1
    [install] = [it for it in errors if it.startswith("apt-get install")]
    assert "package-of-receiver" in install
    assert "package-of-lint" in install
    assert "package-of-view" not in install


def test_packages_that_apt_does_not_have_are_named(checkout: Path) -> None:
    for package in ("some-package", "some-c++"):
        lack(checkout, package)
    apt_knows(checkout, "some-c++")
    program(checkout, "apt-get", 'test "$1" = update')
    program(checkout, "sudo", 'test "$1" = -n && shift; exec "$@"')
    code, errors = run(checkout, "host_receiver/environment/setup.sh")
    assert code == 1
    assert errors[-1].startswith("setup: apt does not have some-package here, as on Debian 12: ")


def test_on_another_processor_setup_says_what_works(checkout: Path) -> None:
    program(checkout, "uname", "echo aarch64")
    setup = "host_receiver/environment/setup.sh"
    code, [error] = run(checkout, setup, "receiver", "headset")
    assert code == 1
    assert error.startswith("setup: the simulated headset runs on x86-64, this processor is aarch")
    lack(checkout, "some-package")
    program(checkout, "apt-get", "exit 100")
    program(checkout, "sudo", 'test "$1" = -n && shift; exec "$@"')
    _, errors = run(checkout, setup, "receiver")
    assert "apt-get cannot read its lists" in errors[-1]


def test_an_unknown_group_is_named_with_those_that_are(checkout: Path) -> None:
    code, errors = run(checkout, "host_receiver/environment/setup.sh", "recieiver")
    assert code == 1
    [error] = errors
    assert error.startswith("setup: no group recieiver: receiver, headset, test")


def test_folders_elsewhere_that_have_our_names_are_not_entered(checkout: Path) -> None:
    (checkout / "elsewhere/host_receiver/environment").mkdir(parents=True)
    command = f"CDPATH={checkout / 'elsewhere'} host_receiver/environment/setup.sh recieiver"
    code, [error] = run(checkout, "bash", "-c", command)
    assert (code, error[:26]) == (1, "setup: no group recieiver:")


def test_variables_for_another_python_are_not_for_ours() -> None:
    program = "import sys; print(sys.flags.safe_path)"
    command: list[Any] = [ROOT / "host_receiver/environment/run.sh", "python3", "-c", program]
    environment = os.environ | {"PYTHONHOME": "/nowhere", "PYTHONSAFEPATH": "1"}
    assert subprocess.check_output(command, env=environment, text=True) == "False\n"


def test_what_compiles_the_app_is_installed_for_every_build() -> None:
    table = (ROOT / "host_receiver/environment/debian-packages.txt").read_text()
    of_app = set(re.findall(r"^\S+ (\S+) app\b", table, re.MULTILINE))
    package = (ROOT / "ml2-sensors-aar/app/package.xml").read_text()
    resources = package[package.index('name="resources"') :].partition("</target>")[0]
    (framework,) = re.findall(r'name="framework" location="([^"]*)"', package)
    assert of_app == {*re.findall(r'executable="([^"]*)"', resources), framework}
    build = re.search(r"^build: (\S+)", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert build is not None
    assert "app" in build[1].split("+")


def test_groups_of_the_makefile_are_those_of_the_table() -> None:
    table = (ROOT / "host_receiver/environment/debian-packages.txt").read_text().splitlines()
    groups = {it for line in table if line[0] != "#" for it in line.split()[2].split(",")}
    makefile = (ROOT / "Makefile").read_text()
    asked = {
        it for match in re.findall(r"(?<= )setup-([a-z+]+)", makefile) for it in match.split("+")
    }
    assert asked == groups - {"receiver"}


@is_root
@pytest.mark.parametrize("packages", ["", "python3-venv python3.12-venv"])
def test_without_root_and_sudo_setup_says_the_command(checkout: Path, packages: str) -> None:
    lack(checkout, "some-package")
    apt_knows(checkout, packages)
    program(checkout, "sudo", "echo 'sudo: a password is required' >&2; exit 1")
    code, errors = run(checkout, "host_receiver/environment/setup.sh", user=NOBODY)
    assert code == 1
    assert errors[-1].startswith("setup: run this, then this again: sudo apt-get install ")
    assert "some-package" in errors[-1]


@is_root
def test_without_root_a_python_that_apt_does_not_have_is_not_asked_of_apt(checkout: Path) -> None:
    apt_knows(checkout, "python3-venv")
    program(checkout, "sudo", "echo 'sudo: a password is required' >&2; exit 1")
    (checkout / "host_receiver/environment/find_python.sh").write_text("#!/bin/sh\nexit 1\n")
    code, errors = run(checkout, "host_receiver/environment/setup.sh", user=NOBODY)
    assert code == 1
    [_, error] = errors  # after that of sudo
    assert "apt does not have here: pyenv install 3.12" in error


def apt_knows(checkout: Path, packages: str) -> None:
    """Takes the place of `apt-cache search --names-only REGEX`."""
    program(checkout, "apt-cache", f'printf "%s\\n" {packages} | grep -E "$3" || true')


@is_root
def test_on_a_full_disk_setup_says_what_to_mend(checkout: Path, full_disk: Path) -> None:
    code, errors = run(checkout, "host_receiver/environment/setup.sh")
    assert code == 1
    assert errors[-1].startswith(f"setup: no Python environment in {full_disk / 'venv'}: mend what")


@is_root
def test_in_a_home_that_cannot_be_written_setup_says_what_to_do(
    checkout: Path, read_only_home: Path
) -> None:
    code, errors = run(checkout, "host_receiver/environment/setup.sh", "headset")
    assert code == 1
    [error] = errors
    assert error.startswith(f"setup: cannot write to your home folder {read_only_home}, where ")
    assert "put HOME=FOLDER before the command" in error


def test_in_an_empty_home_the_first_build_needs_no_list_of_jars(checkout: Path) -> None:
    shutil.copy(ROOT / "pom.xml", checkout)
    program(checkout, "mvn", 'echo "mvn $*" >&2')
    code, errors = run(checkout, "config/kotlin/package.sh", "--batch-mode")
    assert code == 0
    assert errors[-1].startswith("mvn --batch-mode package ")


def test_a_check_of_setup_says_nothing(checkout: Path) -> None:
    assert run(checkout, "host_receiver/environment/setup.sh", "--check") == (1, [])


@pytest.mark.parametrize("module", [".", "simulator", "app"])
def test_a_build_is_made_again_without_the_folder_that_it_made(tmp_path: Path, module: str) -> None:
    shutil.copy(ROOT / "Makefile", tmp_path)
    library, stamp = tmp_path / "ml2-sensors-aar", "build/.maven-packaged"
    native = "build/native/device/libml2sensors.so", "build/native/host/.built"
    made = "native/sim/bundle.sh", *native, "build/native/bundle/order", stamp
    for name in (*(f"ml2-sensors-aar/{it}/pom.xml" for it in (".", "simulator", "app")), *made):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for pom in library.glob("**/pom.xml"):
        (pom.parent / "target").mkdir()
    assert run(tmp_path, "make", "--question", stamp)[0] == 0
    (library / module / "target").rmdir()
    assert run(tmp_path, "make", "--question", stamp)[0] == 1

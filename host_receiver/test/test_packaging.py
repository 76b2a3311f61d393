"""Packages for a ROS workspace and for pip. colcon and ros2 launch are not run here."""

import os
import re
import runpy
import subprocess
import sys
import zipfile
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

import pytest

from ml2_receiver.generated.version import VERSION
from ml2_receiver.table.reader import load_table

RECEIVER = Path(__file__).resolve().parents[1]
PIP_INSTALL = re.compile(r"pip install '([^']*)'")


def test_the_ros_package_has_the_version_and_what_the_table_needs() -> None:
    package = ElementTree.parse(RECEIVER / "package.xml").getroot()
    assert (package.findtext("name"), package.findtext("version")) == ("ml2_receiver", VERSION)
    assert package.findtext("export/build_type") == "ament_python"
    dependencies = {element.text for element in package.iter("exec_depend")}
    table = load_table()
    topics = [topic for stream in table.streams.values() for topic in stream.topics]
    assert {topic.type.partition("/")[0] for topic in topics} <= dependencies


def test_the_wheel_has_the_table_and_what_ros_looks_for(tmp_path: Path) -> None:
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path)]
    source = tmp_path / "source"
    subprocess.run(["cp", "-rL", str(RECEIVER), str(source)], check=True)
    subprocess.run([*build, str(source)], check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    shared = f"ml2_receiver-{VERSION}.data/data/share"
    assert {
        "ml2_receiver/data/streams.yaml",
        "ml2_receiver/data/config.yaml",
        "ml2_tools/data/template.rviz",
        "ml2_tools/viewing/page/index.html",
        "ml2_receiver/ros/node.py",
        "ml2_receiver/py.typed",
        f"{shared}/ament_index/resource_index/packages/ml2_receiver",
        f"{shared}/ml2_receiver/package.xml",
        f"{shared}/ml2_receiver/launch/receiver.launch.py",
    } <= names


def test_a_clone_finds_a_command_that_was_added_to_pyproject(tmp_path: Path) -> None:
    clone = tmp_path / "clone/host_receiver"
    clone.parent.mkdir()
    subprocess.run(["cp", "-rL", RECEIVER, clone], check=True)
    environment = {**os.environ, "ROS_DISTRO": "jazzy"}  # the clone has no environment of its own

    def help_text() -> str:
        command = [str(clone / "ml2-receiver"), "--help"]
        return subprocess.run(
            command, stdout=subprocess.PIPE, text=True, env=environment, check=True
        ).stdout

    assert "salute" not in help_text()
    settings = clone / "pyproject.toml"
    text = settings.read_text()
    settings.write_text(text.replace('\nplay = "', '\nsalute = "salute"\nplay = "'))
    (clone / "salute.py").write_text(
        "def add_parser(subparsers): subparsers.add_parser('salute', help='wave')"
    )
    assert "salute" in help_text()


def test_colcon_can_read_the_setup(tmp_path: Path) -> None:
    """It evaluates what setuptools knows, so that has to be made of literals."""
    source = tmp_path / "source"
    subprocess.run(["cp", "-rL", str(RECEIVER), str(source)], check=True)
    code = (
        "import ast, distutils.core;"
        "d = distutils.core.run_setup('setup.py', [], stop_after='config');"
        "print(ast.literal_eval(repr(d.python_requires)))"
    )
    command = [sys.executable, "-c", f"import setuptools; {code}"]
    done = subprocess.run(command, cwd=source, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == ">=3.12"


def installed_by_name() -> list[str]:
    """Returns the packages that messages and documents tell users to install with pip."""
    code = [RECEIVER / "ml2_receiver", RECEIVER / "ml2_tools"]
    documents = [RECEIVER, RECEIVER.parent / "docs"]
    files = [py for it in code for py in it.rglob("*.py")]
    files += [md for it in documents for md in it.glob("*.md")]
    return sorted({name for it in files for name in PIP_INSTALL.findall(it.read_text())})


def test_what_messages_tell_to_install_is_a_folder_of_the_clone_with_its_extra(
    tmp_path: Path,
) -> None:
    subprocess.run(["cp", "-rL", str(RECEIVER), str(tmp_path / RECEIVER.name)], check=True)
    names = installed_by_name()
    extras = ("evaluate", "products", "view", "zenoh")
    assert {f"./host_receiver[{it}]" for it in extras} <= set(names)
    resolve = ["install", "--dry-run", "--no-deps", "--no-index", "--no-build-isolation"]
    done = subprocess.run(
        [sys.executable, "-m", "pip", *resolve, *names],
        cwd=tmp_path,
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert "does not provide the extra" not in done.stderr
    assert f"Would install ml2_receiver-{VERSION}" in done.stdout.replace("ml2-r", "ml2_r")


class Part:
    """Stands for every class of the launch API: keeps what it is made of."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        self.arguments, self.named = arguments, named

    def perform(self, context: dict[str, str]) -> str:
        return context[self.arguments[0]]


@pytest.fixture
def launch_api(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, classes in {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "OpaqueFunction"],
        "launch.launch_context": ["LaunchContext"],
        "launch.substitutions": ["LaunchConfiguration"],
        "launch_ros": [],
        "launch_ros.actions": ["Node"],
    }.items():
        module = ModuleType(name)
        module.__dict__.update(dict.fromkeys(classes, Part))
        monkeypatch.setitem(sys.modules, name, module)


@pytest.mark.parametrize("config", ["", "my.yaml"])
def test_the_launch_file_passes_its_arguments_on(launch_api: None, config: str) -> None:
    launch = runpy.run_path(str(RECEIVER / "launch/receiver.launch.py"))
    (parts,) = launch["generate_launch_description"]().arguments
    *declared, start = parts
    context = {part.arguments[0]: part.named["default_value"] for part in declared}
    assert set(context) == {"config", "name", "namespace", "listen"}
    context |= {"config": config, "name": "robot1", "namespace": "lab", "listen": "0.0.0.0:1"}
    (node,) = start.named["function"](context)
    options = ["--config", config] if config else []
    listen = ["--listen", "0.0.0.0:1"]
    assert node.named["arguments"] == ["run", *options, "--name", "robot1", *listen]
    assert node.named["namespace"] == "lab"
    assert (node.named["package"], node.named["executable"]) == ("ml2_receiver", "ml2-receiver")

"""Errors tell the user what to do, on a line of its own."""

import errno
import importlib
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from ml2_receiver.cli import main
from ml2_receiver.errors import ReceiverError, file_hint
from ml2_tools.commands.optional_packages import optional_packages

LOCAL = ("--listen", "127.0.0.1:0")
WRONG_CONFIG = "/**: {ros__parameters: {world_left: {enabled: maybe}}}"


def failed(command: Sequence[str], capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    """The last line of the error, and the hint."""
    assert main(command) == 2
    *_, error, hint = capsys.readouterr().err.splitlines()
    assert hint.startswith("hint: ")
    return error, hint.removeprefix("hint: ")


def make_wrong_config(folder: Path) -> Sequence[str]:
    (folder / "my.yaml").write_text(WRONG_CONFIG)
    return ["config", "check", str(folder / "my.yaml")]


def make_open_keys(folder: Path) -> Sequence[str]:
    folder.chmod(0o777)
    return ["record", str(folder / "walk"), "--no-ros", "--keys", str(folder), *LOCAL]


def make_recording(folder: Path) -> Sequence[str]:
    return ["record", str(folder), "--no-ros", "--insecure", *LOCAL]


def make_file_in_the_way(folder: Path) -> Sequence[str]:
    (folder / "file").touch()
    return ["record", str(folder / "file/walk"), "--no-ros", "--insecure", *LOCAL]


def no_address_of_this_machine(folder: Path) -> Sequence[str]:
    walk = str(folder / "walk")
    return ["record", walk, "--no-ros", "--insecure", "--listen", "192.0.2.1:0"]


def no_apk(folder: Path) -> Sequence[str]:
    return ["headset", "install", str(folder / "my.apk")]


@pytest.mark.parametrize(
    ("prepare", "error", "hint"),
    [
        (make_wrong_config, "world_left.enabled: ", "`ml2-receiver config show` lists"),
        (make_open_keys, "others can write in ", "Run `chmod go-w "),
        (make_recording, " exists already", "replace the recording with --overwrite"),
        (make_file_in_the_way, "cannot record into ", "Choose another folder."),
        (no_address_of_this_machine, "cannot listen on 192.0.2.1:0: ", "of this machine"),
        (no_apk, "there is no file ", "Build it with `make apk`"),
    ],
)
def test_an_error_ends_with_what_to_do(
    prepare: Callable[[Path], Sequence[str]],
    error: str,
    hint: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    found = failed(prepare(tmp_path), capsys)
    assert error in found[0]
    assert hint in found[1]


def test_without_adb_it_says_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    error, hint = failed(["headset", "status"], capsys)
    assert error == "adb is not installed, or not on PATH"
    assert "sudo apt install adb" in hint


def test_without_ros_it_says_what_to_source() -> None:
    script = (
        "import sys; sys.modules['rclpy'] = None;"
        "from ml2_receiver.cli import main;"
        "sys.exit(main(['run', '--insecure', '--listen', '127.0.0.1:0']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], check=False, capture_output=True, text=True
    )
    error, hint = done.stderr.splitlines()[-2:]
    assert done.returncode == 2
    assert error == "ROS 2 is not available: Python finds no rclpy"
    assert hint.startswith("hint: Run `source /opt/ros/jazzy/setup.bash`")
    assert "record --no-ros" in hint


APT = "Run `sudo apt install {}`, or in the clone `pip install './host_receiver[{}]'`."


@pytest.mark.parametrize(
    ("command", "package", "hint"),
    [
        ("products", "cv2", APT.format("python3-opencv", "products")),
        ("view", "cv2", APT.format("python3-opencv", "view")),
        ("view", "websockets", "Run in the clone `pip install './host_receiver[view]'`."),
        (
            *("evaluate --bag b --camera world_left", "matplotlib"),
            APT.format("python3-matplotlib", "evaluate"),
        ),
    ],
)
def test_without_an_optional_package_it_says_how_to_install_it(
    command: str, package: str, hint: str
) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    script = (
        f"import sys; sys.modules[{package!r}] = None;"
        "from ml2_receiver.cli import main;"
        f"sys.exit(main({command.split()}))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], check=False, capture_output=True, text=True
    )
    assert done.returncode == 2
    name = command.partition(" ")[0]
    assert done.stderr.splitlines() == [
        f"`{name}` needs {package}, which is not installed",
        f"hint: {hint}",
    ]


def test_another_missing_module_is_an_error_of_our_own() -> None:
    with (
        pytest.raises(ModuleNotFoundError, match="no_such_module"),
        optional_packages("cv2", command="view", pip="pip install './host_receiver[view]'"),
    ):
        importlib.import_module("no_such_module")


@pytest.mark.parametrize(
    ("code", "hint"),
    [
        (errno.ENOSPC, "Free space on that disk, or take another."),
        (errno.EACCES, "Give your user access to it, or take another."),
        (errno.ENOTDIR, "Take another."),
    ],
)
def test_a_hint_on_a_file_depends_on_what_failed(code: int, hint: str) -> None:
    assert file_hint(OSError(code, "..."), "take another") == hint


def test_a_message_without_a_hint_is_one_line() -> None:
    assert ReceiverError("no").in_one_line() == "no"
    assert ReceiverError("no", hint="Try again.").in_one_line() == "no. Try again."

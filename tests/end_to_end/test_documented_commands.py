"""Each command of the documents that can run here runs, in a clone, in the order of its page.

A simulated headset is on the other side, in a network of its own, so that the documents' ports are
free. Commands that run until Ctrl-C go on until their page ends or their port is needed again. The
shell runs those of IN_SHELL; those of other pages are forks, which start at once.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import adb_stand_in
from document import ROOT, blocks, commands, files
from forked import ForkedPython
from left_out import left_out
from processes import paired
from ros_domain import reserve_domain
from waiting import LIMIT_S, await_true

HEADSET, HERE = "ml2-sensors-aar/simulator/ml2-headset", "--receiver 127.0.0.1:7755"
RECEIVER = "host_receiver/ml2-receiver"
IN_SHELL = "docs/security.md"
# Patterns of commands that cannot run here, with the reason. Every other command runs.
NOT_HERE = {
    r"(sudo|apt-get) ": "changes the machine",
    r"(adb|ssh|rviz2|ros2|colcon) ": "not on this machine",
    r"(mono_euroc|kalibr_\w+|basalt_\w+) ": "not on this machine",
    r"(git clone|make) ": "what CI begins with: .ci/run",
    r"KEYSTORE_PASSWORD=": "needs a key",
    r"(pip|\S*/pip) install ": "host_receiver/test/test_packaging.py resolves them",
    r"(source|cd|mkdir|python3 -m venv|~/ml2/) ?": "needs ROS 2 from apt",
    r"receiver/bin/": "tests/dist/test_installed.py",
    r"\S+ run .*--zenoh ": "host_receiver/test/test_command_run_zenoh.py; needs a router",
    r"host_receiver/environment/run.sh python3 config/generate.py": "lint runs it with --check",
    r"\S+ python3 my_program.py": "host_receiver/test/test_own_program.py",
    r"\S+ headset selftest": "tests/end_to_end/test_selftest.py",
    r"\S+ headset install": "host_receiver/test/test_command_headset.py, with a package",
    r"\S+ export --tum ": "host_receiver/test/test_export_tum.py, with depth",
    r"\S+ evaluate ": "host_receiver/test/test_command_evaluate.py, on a walk",
    r"\S+ calibrate imu --bag ": "tests/end_to_end/test_imu_calibration.py, on a walk",
    r"\S+ play ": "host_receiver/test/test_command_play.py; the port has its headset here",
    r"\S+ .*--replay ": "tests/end_to_end/test_replay.py",
}
# The pages name files and values of the reader; these stand for them here.
REPLACED = {
    "--duration 60 --topic": "--duration 2 --topic",
    " --duration 60": "",  # ends once there is enough
    "/data/walk": "data_walk",
    "--receiver desk": HERE,
    "Magic Leap 2": "Simulated headset, seed 1",
}
# The file that the first block of YAML on a page is to be saved as.
SAVED = {
    "docs/slam.md": "slam.yaml",
    "docs/add_a_sensor.md": "light.yaml",
    "docs/shared_space.md": "markers.yaml",
    "host_receiver/README.md": "my.yaml",
}
SERVES = re.compile(r"\S+ (run|record(?!.*(--duration|--attach)))\b")
STAYS = re.compile(r"\S+ (pair|view|products|compat|record .*--attach)\b")
IS_HEADSET = re.compile(rf"{HEADSET}\b(?!.*--pair)")
IN_A_WALK, IN_ANY = 5_000_000, 10_000  # bytes
PAIRS, RECORDS = re.compile(r"\S+ pair\b"), re.compile(r"\S+ record\b")
WATCHES = re.compile(r"\S+ (topics|latency|echo)\b(?!.*--once)")
NEEDS_RECEIVER = re.compile(
    rf"{HEADSET}\b(?!.*--pair)|"
    r"\S+ (topics|latency|echo|set|call|devices(?!.*--paired)|doctor|products|compat"
    r"|record.*--attach|export --kalibr \w+(?!.*--bag)|view(?! \w))\b"
)
LIVE_EXPORT = re.compile(r"\S+ export --kalibr \w+(?!.*--bag)")
NEEDS_NO_HEADSET = re.compile(r"\S+ messages\b")


def runnable(page: Path) -> list[str]:
    lines = commands(page.read_text())
    return [it for it in lines if not any(re.match(rule, it) for rule in NOT_HERE)]


class Typed:
    """A command that was typed, with what it has said."""

    def __init__(self, line: str, reader: Reader, stdin: str = "") -> None:
        self.line = line
        self.log = reader.folder / f"{len(reader.typed)}.log"
        with self.log.open("w") as output:
            options: dict[str, Any] = {
                "cwd": reader.clone,
                "env": reader.environment,
                "stdin": subprocess.PIPE,
                "stdout": output,
                "stderr": output,
                "text": True,
            }
            words = shlex.split(line, comments=True)
            self.process: subprocess.Popen[str]
            if words[0] == RECEIVER and not reader.has_shell:
                python = [sys.executable, "-m", "ml2_receiver", *words[1:]]
                self.process = ForkedPython(python, network=reader.network, **options)
            else:
                shell = ["ip", "netns", "exec", reader.network, "bash", "-c", f"exec {line}"]
                self.process = subprocess.Popen(shell, **options)
        assert self.process.stdin is not None
        self.process.stdin.write(stdin)
        self.process.stdin.close()

    @property
    def said(self) -> str:
        return self.log.read_text(errors="replace")

    def await_said(self, words: str = "\n") -> None:
        await_true(lambda: words in self.said or self.process.poll() is not None)
        assert words in self.said, f"{self.line}: {self.said}"

    def end(self, *codes: int) -> None:
        """Waits until it ends; Ctrl-C first, if only an interrupt ends it."""
        code = self.process.wait(LIMIT_S)
        assert code in codes, f"{self.line}: {code}: {self.said}"

    def interrupt(self) -> None:
        """Ends it by Ctrl-C, once it has said something: that would kill the shell of a start."""
        if self.process.poll() is None:
            self.await_said()
            self.process.send_signal(signal.SIGINT)
            self.process.wait(LIMIT_S)
            # 1: a camera of `ml2-headset` waits for its first image; 2: `pair` has paired nobody
            is_drawing = left_out(self.log) and "failed: " not in self.said
            self.end(0, 2, 130, *([1] if is_drawing else []))


class Reader:
    """Types the commands of a page in a folder that looks like a clone."""

    def __init__(self, folder: Path, network: str, has_shell: bool = False) -> None:
        self.folder, self.clone = folder, folder / "clone"
        self.network, self.has_shell = network, has_shell
        self.clone.mkdir()
        for name in ROOT.iterdir():
            (self.clone / name.name).symlink_to(name)
        self.environment = (
            os.environ
            | adb_stand_in.installed(folder)
            | {
                "BROWSER": "true",
                "HOME": str(folder),
                "JDK_JAVA_OPTIONS": f"-Dnet.mdns.interface=127.0.0.1 -Duser.home={folder}",
                "PYTHONUNBUFFERED": "1",
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                "ROS_DOMAIN_ID": str(reserve_domain()),
                "XDG_CONFIG_HOME": str(folder / "config"),
            }
        )
        self.typed: list[Typed] = []
        self.brings_headset = False

    def bring_headset(self, keys: Path) -> None:
        """Starts one that is paired by the keys of paired()."""
        for role, name in (("receiver", "ml2-sensors"), ("headset", "ml2-sensors-headset")):
            shutil.copytree(keys / role, self.folder / "config" / name)
        self.start(f"{HEADSET} {HERE}")
        self.brings_headset = True

    def start(self, line: str, stdin: str = "") -> Typed:
        self.typed.append(Typed(line, self, stdin))
        return self.typed[-1]

    def running(self, rule: re.Pattern[str]) -> list[Typed]:
        return [it for it in self.typed if rule.match(it.line) and it.process.poll() is None]

    def type(self, line: str) -> None:
        is_walk = "--duration 60" in line
        for old, new in REPLACED.items():
            line = line.replace(old, new)
        words = shlex.split(line, comments=True)
        self._clear(line, words)
        self._prepare(line, words)
        if IS_HEADSET.match(line):
            self._connect(line)
        elif SERVES.match(line) or STAYS.match(line):
            started = self.start(line)
            started.await_said()
            if SERVES.match(line) and self.brings_headset and port(line) == "7755":
                started.await_said(" connected")
            if RECORDS.match(line) and "--attach" not in line:
                folder = self.clone / words[2]
                least = IN_A_WALK if is_walk else IN_ANY
                await_true(lambda: sum(it.stat().st_size for it in folder.glob("*.mcap")) > least)
        elif WATCHES.match(line):
            watching = self.start(line)
            watching.await_said()
            watching.interrupt()
        elif "--pair -" in line:
            self._pair(line)
        elif LIVE_EXPORT.match(line):
            # On a slow machine, what it needs may not come while it waits for it.
            await_true(lambda: self.start(line).process.wait(LIMIT_S) == 0)
        else:
            self.start(line).end(
                0, *[1] * (words[1] in ("doctor", "inspect"))
            )  # 1: it found something

    def _connect(self, line: str) -> None:
        for it in self.running(IS_HEADSET):
            it.interrupt()
        receiver = self.running(SERVES)[-1]
        earlier = receiver.said.count(" connected")
        self.start(line)
        await_true(lambda: receiver.said.count(" connected") > earlier)

    def _pair(self, line: str) -> None:
        if not self.running(PAIRS):
            self.start(f"{RECEIVER} pair").await_said()
        (pairing,) = self.running(PAIRS)
        uri = pairing.said.splitlines()[0]
        self.start(line, f"{uri}\n").end(0)
        if HEADSET not in line:  # behind the stand-in of adb there is no headset
            self.start(f"{HEADSET} --pair '{uri}'").end(0)
        pairing.end(0)

    def _clear(self, line: str, words: list[str]) -> None:
        """Ends and removes what is in the way of a command."""
        for recording in self.running(RECORDS):
            if recording.line.split()[2] in words:
                recording.interrupt()
        if words[1:2] == ["record"]:
            subprocess.run(["rm", "-rf", words[2]], cwd=self.clone, check=True)
        if SERVES.match(line) or (words[1:2] == ["record"] and "--attach" not in words):
            for other in self.running(SERVES):
                if port(other.line) == port(line):
                    other.interrupt()

    def _prepare(self, line: str, words: list[str]) -> None:
        """Starts what a page takes for granted."""
        if "walk" in words and "record" not in words and not (self.clone / "walk").exists():
            self.type(f"{RECEIVER} record walk --duration 60")
        if not NEEDS_RECEIVER.match(line):
            return
        name = name_of(line)
        serving = [it for it in self.running(SERVES) if name_of(it.line) == name]
        if not serving:
            named = f" --name {name} --listen 127.0.0.1:7757" if name else ""
            serving.append(self.start(f"{RECEIVER} run{named}"))
            serving[0].await_said()
        if self.brings_headset and not name:
            serving[-1].await_said(" connected")


def name_of(line: str) -> str:
    found = re.search(r"--name (\w+)", line)
    return found[1] if found else ""


def port(line: str) -> str:
    found = re.search(r"--listen \S+:(\d+)", line)
    return found[1] if found else "7755"


PAGES = [str(it.relative_to(ROOT)) for it in files("*.md") if runnable(it)]


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys")
    paired(folder)
    return folder


@pytest.mark.parametrize("page", PAGES)
def test_the_commands_of_a_page_run_in_their_order(
    page: str, network: str, keys: Path, tmp_path: Path
) -> None:
    reader = Reader(tmp_path, network, has_shell=page == IN_SHELL)
    lines = runnable(ROOT / page)
    if page in SAVED:
        text, *_ = blocks((ROOT / page).read_text(), r"yaml")
        (reader.clone / SAVED[page]).write_text(text)
    try:
        brings_its_own = any(HEADSET in it for it in lines)
        if not brings_its_own and not all(map(NEEDS_NO_HEADSET.match, lines)):
            reader.bring_headset(keys)
        for line in lines:
            reader.type(line)
        for it in reversed(reader.typed):
            it.interrupt()
    finally:
        for it in reader.typed:
            it.process.kill()
            it.process.wait()


def test_what_cannot_run_here_is_still_in_the_documents() -> None:
    lines = [line for it in files("*.md") for line in commands(it.read_text())]
    assert [rule for rule in NOT_HERE if not any(re.match(rule, it) for it in lines)] == []

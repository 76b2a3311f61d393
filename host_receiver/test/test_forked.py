"""A fork is, to itself and to others, the program that it stands for."""

import array
import fcntl
import os
import signal
import subprocess
import sys
import termios
from pathlib import Path

import psutil
import pytest

from forked import ForkedPython
from ros_processes import Child
from waiting import await_true

PROGRAM = """
import os, sys
import beside, given
print(os.getcwd(), os.environ["ROS_DOMAIN_ID"], *sys.argv, flush=True)
sys.stdin.read()
"""


@pytest.mark.parametrize("is_module", [False, True])
def test_others_see_its_command_line_and_environment(tmp_path: Path, is_module: bool) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    (tmp_path / "beside.py").touch()
    other = tmp_path / "other"
    other.mkdir()
    (other / "given.py").touch()
    file = str(tmp_path / "program.py")
    command = [sys.executable, *(["-m", "program"] if is_module else [file]), "a b", "ü"]
    environ = {**os.environ, "ROS_DOMAIN_ID": "77", "PYTHONPATH": str(other)}
    pipe = subprocess.PIPE
    with ForkedPython(
        command, env=environ, cwd=tmp_path, stdin=pipe, stdout=pipe, text=True
    ) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == f"{tmp_path} 77 {file} a b ü\n"
        seen = psutil.Process(child.pid)
        assert list(filter(None, seen.cmdline())) == command
        assert seen.environ() == environ
        assert seen.ppid() == os.getpid()
        child.communicate("")
    assert child.returncode == 0


def test_a_line_is_whole_whose_writer_stands_still_while_nobody_reads(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text("print('x' * 1_000_000, flush=True)")
    with ForkedPython([sys.executable, str(program)], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        pipe = child.stdout.fileno()
        capacity = fcntl.fcntl(pipe, fcntl.F_GETPIPE_SZ)
        await_true(lambda: unread_bytes(pipe) == capacity)
        child.send_signal(signal.SIGSTOP)
        await_true(lambda: psutil.Process(child.pid).status() == psutil.STATUS_STOPPED)
        child.send_signal(signal.SIGCONT)
        assert child.stdout.read() == "x" * 1_000_000 + "\n"
    assert child.returncode == 0


def test_where_a_program_hangs_is_said(tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text("print('ready'); input()")
    with Child(str(program)) as child:
        assert child.line() == "ready"
        with pytest.raises(AssertionError, match=r'program.py", line 1 in <module>'):
            child.line(0)


def test_programs_of_tests_in_the_background_of_a_script_can_be_interrupted() -> None:
    words = "import own_environment, signal; print(signal.getsignal(signal.SIGINT).__name__)"
    command = ["env", "--ignore-signal=INT", sys.executable, "-c", words]
    folder = Path(__file__).parent
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert run.stdout == "default_int_handler\n"


def unread_bytes(pipe: int) -> int:
    count = array.array("i", [0])
    fcntl.ioctl(pipe, termios.FIONREAD, count)
    return count[0]

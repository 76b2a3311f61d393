"""A fork is, to itself and to others, the program that it stands for."""

import os
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from forked import ForkedPython

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

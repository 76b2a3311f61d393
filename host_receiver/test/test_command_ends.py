"""How every command ends when the user, or who reads its output, has had enough."""

import os
import signal
import subprocess
import sys
from importlib.metadata import entry_points

import pytest

from ros_processes import Child, environment
from waiting import LIMIT_S

COMMANDS = sorted({it.name for it in entry_points(group="ml2_receiver.commands")})
# Any command, of which the arguments are right, and which then works for long.
WORKING = """
import argparse, signal, sys
from ml2_receiver import cli

def work(_):
    print("works", flush=True)
    signal.pause()

parser = argparse.ArgumentParser()
parser.parse_args = lambda _: argparse.Namespace(run=work)
cli.command_line = lambda _: parser
sys.exit(cli.main(sys.argv[1:]))
"""


def test_there_are_commands() -> None:
    assert {"run", "evaluate", "devices"} <= set(COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_ctrl_c_ends_a_command_without_a_traceback(command: str) -> None:
    with Child("-c", WORKING, command) as child:
        assert child.line() == "works"
        assert child.end(signal.SIGINT) == 130
    assert child.errors == []


@pytest.mark.parametrize(
    "words",
    [
        *(f"{command} --help" for command in COMMANDS),
        *("--help", "--print-completion bash", "config show", "config show --json"),
    ],
)
def test_who_reads_no_more_gets_no_traceback(words: str) -> None:
    command = [sys.executable, "-m", "ml2_receiver", *words.split()]
    reading, writing = os.pipe()
    os.close(reading)
    run = subprocess.run(
        command,
        env=environment(),
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    os.close(writing)
    assert run.stderr == ""
    assert run.returncode in (0, 1, 141)  # 0 of argparse, and 1 of rich, which see it first
    assert run.returncode == 141 or "json" not in words

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from command_line import refusal
from ml2_receiver.cli import command_line, main

# As a shell has them
MODULE = f"{shlex.quote(sys.executable)} -m ml2_receiver"
FROM_A_CLONE = shlex.quote(str(Path(__file__).resolve().parents[1] / "ml2-receiver"))
COMMANDS = [
    ["config", "check"],
    ["config", "show"],
    ["devices"],
    ["doctor"],
    ["inspect"],
    ["latency"],
    ["pair"],
    ["run"],
    ["topics"],
    ["unpair"],
]


@pytest.mark.parametrize("command", [[], *COMMANDS])
def test_every_help_has_examples(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main([*command, "--help"])
    help = capsys.readouterr().out
    assert "\nexamples:\n  ml2-receiver" in help
    assert max(map(len, help.splitlines())) <= 100


@pytest.mark.parametrize(
    ("words", "meant"), [(["docter"], "doctor"), (["topic"], "topics"), (["config", "shw"], "show")]
)
def test_a_misspelt_command_is_guessed(words: list[str], meant: str) -> None:
    assert f"did you mean {meant}?" in refusal(*words)


def test_a_word_like_no_other_is_not_guessed() -> None:
    error = refusal("xyzzy")
    assert "invalid choice: 'xyzzy'" in error
    assert "did you mean" not in error


@pytest.mark.parametrize(
    ("output", "code", "said"),
    [
        (">&-", 0, ""),
        ("<&- >&-", 0, ""),
        (">/dev/full", 2, "the output cannot be written: No space left on device\n"),
    ],
)
@pytest.mark.parametrize("words", ["config show", "config show --json"])
def test_an_output_that_is_missing_or_full_is_no_traceback(
    words: str, output: str, code: int, said: str
) -> None:
    command = ["bash", "-c", f"exec {MODULE} {words} {output}"]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (code, said)


@pytest.mark.parametrize("program", [MODULE, FROM_A_CLONE], ids=["module", "clone"])
@pytest.mark.parametrize("errors", ["2>&-", "2>/dev/full", "2> >(exec true)"])
def test_an_error_that_cannot_be_written_is_still_exit_code_2(program: str, errors: str) -> None:
    command = ["bash", "-c", f"exec {program} unpair nobody {errors}"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")


@pytest.mark.parametrize("output", [">&- 2>&-", ">/dev/full 2>&1"])
def test_neither_output_is_needed(output: str) -> None:
    command = ["bash", "-c", f"exec {FROM_A_CLONE} config show {output}"]
    assert subprocess.run(command, check=False).returncode == (2 if "full" in output else 0)


def test_without_a_command_all_are_listed_in_groups_on_a_line_each() -> None:
    command = [sys.executable, "-m", "ml2_receiver"]
    environment = os.environ | {"COLUMNS": "80"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (2, "")
    groups = ("everyday", "look", "record", "set up", "diagnose", "options")
    parts = re.split(rf"^({'|'.join(groups)}):$", done.stdout, flags=re.MULTILINE)
    assert tuple(parts[1::2]) == groups
    listed = [line for part in parts[2:-1:2] for line in part.strip("\n").splitlines()]
    named = [match[1] for line in listed if (match := re.match(r"  (\w+) +\S.*$", line))]
    (commands,) = (it.choices for it in command_line()._actions if isinstance(it.choices, dict))
    assert len(named) == len(listed)
    assert sorted(named) == sorted(commands)
    assert max(map(len, listed)) <= 80


@pytest.mark.parametrize(
    ("words", "command", "meant"),
    [
        ("run --lisen 0.0.0.0:7755", "run", "--listen"),
        ("config check my.yaml --lonk=100", "config check", "--link"),
        ("echo --onec", "echo", "--once"),
        ("--versoin", "", "--version"),
    ],
)
def test_a_misspelt_option_is_guessed_with_the_usage_of_its_command(
    words: str, command: str, meant: str
) -> None:
    usage, *_, error = refusal(*words.split()).splitlines()
    assert usage.startswith(f"usage: {f'ml2-receiver {command}'.strip()} [")
    assert error.endswith(f"; did you mean {meant}?")


def test_what_follows_ros_args_is_not_ours() -> None:
    options = command_line().parse_args(["topics", "--ros-args", "--remap", "/tf:=tf"])
    assert options.ros_args == ["--remap", "/tf:=tf"]


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("ml2-receiver do", "doctor"),
        ("ml2-receiver config sh", "show"),
        ("ml2-receiver run --li", "--listen"),
        ("ml2-receiver echo light", "light_sensor"),
        ("ml2-receiver record walk --topic hand_l", "hand_left"),
        ("ml2-receiver play walk --topics /tf depth/conf", "depth/confidence"),
        ("ml2-receiver headset grant controller_", "controller_joy"),
        ("ml2-receiver call save_config tf.", "tf.layout"),
        ("ml2-receiver set tf.", "tf.layout=flat tf.layout=rig"),
        ("ml2-receiver set tf.layout=r", "rig"),
        ("ml2-receiver set picture_center.mode=4096", "4096x3072@15 4096x3072@30"),
    ],
)
def test_bash_completes_what_was_begun(
    typed: str, offered: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--print-completion", "bash"])
    words = re.split(r" |(?<==)|(?==)", typed)  # as bash does it
    ask = f"""
COMP_WORDS=({" ".join(words)}); COMP_CWORD={len(words) - 1}; COMP_LINE="{typed}"
COMP_POINT={len(typed)}
function_name=$(complete -p ml2-receiver | sed 's/.*-F \\([^ ]*\\).*/\\1/')
"$function_name" ml2-receiver {words[-1]} {words[-2]}; echo "${{COMPREPLY[@]}}"
"""
    script = capfd.readouterr().out + ask
    answer = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert answer.stdout.split() == offered.split()

import subprocess

import pytest

from ml2_receiver.cli import main
from refusals import refusal

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
    ("typed", "offered"),
    [
        ("ml2-receiver do", "doctor"),
        ("ml2-receiver config sh", "show"),
        ("ml2-receiver run --li", "--listen"),
    ],
)
def test_bash_completes_what_was_begun(
    typed: str, offered: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--print-completion", "bash"])
    words = typed.split()
    ask = f"""
COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; COMP_LINE="{typed}"
function_name=$(complete -p ml2-receiver | sed 's/.*-F \\([^ ]*\\).*/\\1/')
"$function_name" ml2-receiver {words[-1]} {words[-2]}; echo "${{COMPREPLY[@]}}"
"""
    script = capfd.readouterr().out + ask
    answer = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True)
    assert answer.stdout.split() == [offered]

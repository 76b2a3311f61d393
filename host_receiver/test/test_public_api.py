"""The public API: the command with its options, and the names in __all__."""

import argparse
import inspect

import pytest

from api_dump import ROOT, assert_is_committed
from command_line import Words, with_subcommands
from ml2_receiver import cli

PUBLIC_MODULES = [cli]


@pytest.fixture(scope="module")
def parsers() -> dict[Words, argparse.ArgumentParser]:
    return dict(with_subcommands(("ml2-receiver",), cli.command_line()))


def options(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    return [
        action for action in parser._actions if not isinstance(action, argparse._SubParsersAction)
    ]


def test_the_interface_changes_on_purpose_only(
    parsers: dict[Words, argparse.ArgumentParser],
) -> None:
    lines = [
        f"{module.__name__}.{name}{inspect.signature(getattr(module, name))}"
        for module in PUBLIC_MODULES
        for name in module.__all__
    ]
    for words, parser in parsers.items():
        lines.append(" ".join(words))
        lines += sorted(f"  {described(option)}" for option in options(parser))
    assert_is_committed("\n".join(lines) + "\n", ROOT / "host_receiver/api/ml2_receiver.api")


def described(option: argparse.Action) -> str:
    names = "|".join(option.option_strings) or option.dest
    choices = () if option.dest == "print_completion" else option.choices  # those of any shtab
    values = "|".join(map(str, choices or ())) or ("" if option.nargs == 0 else "VALUE")
    repeated = str(option.nargs) if option.nargs in ("?", "*", "+") else ""
    needed = " required" if option.required and option.option_strings else ""
    return f"{names} {values}{repeated}".rstrip() + needed


def test_everything_is_documented(parsers: dict[Words, argparse.ArgumentParser]) -> None:
    undocumented = [
        f"{module.__name__}.{name}"
        for module in PUBLIC_MODULES
        for name in module.__all__
        if not inspect.getdoc(getattr(module, name))
    ]
    undocumented += [
        f"{' '.join(words)} {option.dest}"
        for words, parser in parsers.items()
        for option in options(parser)
        if not option.help
    ]
    assert undocumented == []
    assert len(parsers) > 20

"""The C interface as clang reads ml2s.h; device/check.sh compares it with the library's exports."""

import json
import re
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest

from api_dump import ROOT, assert_is_committed

HEADER = ROOT / "native/sdk/ml2s.h"
CLANG = ("clang", "--target=x86_64-linux-android29", "-ffreestanding", "-nostdlibinc")
NAMED = ("FunctionDecl", "RecordDecl", "EnumDecl", "EnumConstantDecl", "FieldDecl")
SAID_OF_ALL = ("struct_size", "reserved")
LAYOUT = re.compile(
    r"^ +0 \| struct (ml2s_\w+\n.*?sizeof=\d+, align=\d+\])", re.MULTILINE | re.DOTALL
)

Declaration = dict[str, Any]


def clang(*options: str) -> str:
    command = [*CLANG, *options, str(HEADER)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


@pytest.fixture(scope="module")
def declarations() -> list[Declaration]:
    """Returns the declarations of the header and of the one it includes, with members."""
    tree = json.loads(clang("-fsyntax-only", "-Xclang", "-ast-dump=json"))
    return [found for found in walk(tree) if found["kind"] in NAMED and found.get("name")]


def walk(node: Declaration) -> Iterator[Declaration]:
    for inner in node.get("inner", []):
        if inner.get("kind") != "ParmVarDecl":
            yield inner
            yield from walk(inner)


def test_everything_is_documented(declarations: list[Declaration]) -> None:
    undocumented = [
        declaration["name"]
        for declaration in declarations
        if declaration["name"] not in SAID_OF_ALL
        and not any(inner["kind"] == "FullComment" for inner in declaration.get("inner", []))
    ]
    assert undocumented == []
    assert len(declarations) > 100


def test_the_abi_changes_on_purpose_only(declarations: list[Declaration]) -> None:
    lines = [*constants(declarations), *functions(declarations), *structures()]
    assert_is_committed("\n".join(lines) + "\n", ROOT / "native/api/ml2s.api")


def constants(declarations: list[Declaration]) -> Iterator[str]:
    macros = re.findall(r"^#define (ML2S_(?!API\b).*)", clang("-E", "-dM"), re.MULTILINE)
    yield from sorted(macros)
    for declaration in declarations:
        if declaration["kind"] == "EnumConstantDecl":
            value = next(inner["value"] for inner in walk(declaration) if "value" in inner)
            yield f"{declaration['name']} = {value}"


def functions(declarations: list[Declaration]) -> Iterator[str]:
    for declaration in declarations:
        if declaration["kind"] == "FunctionDecl":
            result, parameters = declaration["type"]["qualType"].split(" (", 1)
            yield f"{result} {declaration['name']}({parameters}"


def structures() -> list[str]:
    """Offsets, types and sizes."""
    layouts = clang("-fsyntax-only", "-Xclang", "-fdump-record-layouts-complete")
    return [re.sub(" +", " ", f"struct {layout}") for layout in LAYOUT.findall(layouts)]

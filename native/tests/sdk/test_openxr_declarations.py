"""Declarations of OpenXR extensions, compared with pyopenxr, made from Khronos' registry."""

import ctypes
import importlib
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import pytest

from api_dump import ROOT

HEADER = ROOT / "native/openxr/xr_ml.h"
TEXT = HEADER.read_text()


@pytest.fixture(scope="module")
def binding() -> ModuleType:
    """Imports the structures and numbers only: the package itself needs a graphics library."""
    found = find_spec("xr")
    assert found is not None
    assert found.submodule_search_locations is not None
    package = ModuleType("xr")
    package.__path__ = list(found.submodule_search_locations)
    package.__spec__ = found  # for others who look for it in this process
    sys.modules["xr"] = package
    return importlib.import_module("xr.typedefs")


def printed(tmp_path: Path, expressions: dict[str, str]) -> dict[str, int]:
    """Returns what a C compiler makes of constant expressions."""
    lines = "".join(
        f'printf("{name} %lld\\n", (long long)({expression}));\n'
        for name, expression in expressions.items()
    )
    source, program = tmp_path / "print.c", tmp_path / "print"
    includes = f'#include <stddef.h>\n#include <stdio.h>\n#include "{HEADER}"\n'
    source.write_text(f"{includes}int main(void) {{\n{lines}}}\n")
    subprocess.run(["clang", "-Wall", "-Werror", "-o", program, source], check=True)
    output = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    return {name: int(value) for name, value in (line.split() for line in output.splitlines())}


def test_structures_have_the_layout_of_another_binding(binding: ModuleType, tmp_path: Path) -> None:
    names = re.findall(r"^typedef struct Xr(\w+) \{", TEXT, re.MULTILINE)
    assert len(names) > 15
    expressions, expected = {}, {}
    for name in names:
        structure = getattr(binding, name)
        expressions[name] = f"sizeof(Xr{name})"
        expected[name] = ctypes.sizeof(structure)
        for field in fields(structure):
            member = re.sub(r"_(\w)", lambda it: it[1].upper(), field.removeprefix("_"))
            expressions[f"{name}.{member}"] = f"offsetof(Xr{name}, {member})"
            expected[f"{name}.{member}"] = getattr(structure, field).offset
    assert sum(len(body.split(";")) - 1 for body in bodies()) == len(expected) - len(names)
    assert printed(tmp_path, expressions) == expected


def fields(structure: type[ctypes.Structure]) -> list[str]:
    """Returns the fields, those of the base classes first."""
    own = [
        field for kind in reversed(structure.__mro__) for field in vars(kind).get("_fields_", ())
    ]
    return [field[0] for field in own]


def bodies() -> list[str]:
    return re.findall(r"^typedef struct \w+ \{(.*?)^\}", TEXT, re.MULTILINE | re.DOTALL)


def test_numbers_are_those_of_another_binding(binding: ModuleType, tmp_path: Path) -> None:
    enums = importlib.import_module(f"{binding.__package__}.enums")
    expected = {}
    for macro in re.findall(r"^#define (XR_(?:TYPE|ERROR)_\w+) \(", TEXT, re.MULTILINE):
        kind, name = macro.removeprefix("XR_").split("_", 1)
        table = enums.StructureType if kind == "TYPE" else enums.Result
        expected[macro] = table[name if kind == "TYPE" else f"ERROR_{name}"].value
    for kind, vendor, body in re.findall(
        r"^typedef enum Xr(\w+?)(ML|EXT) \{(.*?)^\}", TEXT, re.MULTILINE | re.DOTALL
    ):
        prefix = "XR_" + re.sub(r"(?<!^)(?=[A-Z])", "_", kind).upper() + "_"
        members = getattr(enums, kind + vendor).__members__
        for name in re.findall(r"(XR_\w+) = \d", body):
            member = name.removeprefix(prefix).removesuffix(f"_{vendor}")
            if member != "MAX_ENUM":
                # The binding puts N before a digit.
                expected[name] = members[re.sub(r"^(?=\d)", "N", member)].value
    for name in re.findall(r"^#define XR_LOCALIZATION_MAP_ERROR_(\w+)_ML \d", TEXT, re.MULTILINE):
        member = enums.LocalizationMapErrorFlagsML[name]
        expected[f"XR_LOCALIZATION_MAP_ERROR_{name}_ML"] = member.value
    for name in re.findall(r"^#define XR_REFERENCE_SPACE_TYPE_(\w+)", TEXT, re.MULTILINE):
        member = enums.ReferenceSpaceType[name]
        expected[f"XR_REFERENCE_SPACE_TYPE_{name}"] = member.value
    assert len(expected) > 70
    assert printed(tmp_path, {name: name for name in expected}) == expected


def test_names_of_extensions_are_those_of_another_binding(binding: ModuleType) -> None:
    constants = importlib.import_module(f"{binding.__package__}.constants")
    found = re.findall(r'#define XR_(\w+_EXTENSION_NAME) "(\w+)"', TEXT)
    assert len(found) == 5
    for name, text in found:
        assert getattr(constants, name) == text

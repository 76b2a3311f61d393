"""The library in the packages, as the linker of the headset will see it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from toolchain import ROOT, Package, run

# Equal in bionic and glibc; what else the headset's linker would have to find must first be known to be.
IMPORTS = {
    "__android_log_print",
    "clock_gettime",
    "dlerror",
    "dlopen",
    "dlsym",
    "gettid",
    "memcpy",
    "memmove",
    "memset",
    "strcmp",
    "strlen",
}


@pytest.fixture
def device_library(package: Package) -> Path:
    return package.folder / "jni" / "x86_64" / "libml2sensors.so"


def symbols(library: Path) -> tuple[set[str], set[str]]:
    """The names it exports, and those it imports."""
    table = run("readelf", "--wide", "--dyn-syms", library)
    rows = re.findall(r"(?:GLOBAL|WEAK)\s+\S+\s+(\S+)\s+(\S+)$", table, re.MULTILINE)
    return {name for at, name in rows if at != "UND"}, {name for at, name in rows if at == "UND"}


def test_it_is_for_the_processor_of_the_headset(device_library: Path) -> None:
    header = run("readelf", "--file-header", device_library)
    assert re.search(r"Class:\s+ELF64\n", header)
    assert "Advanced Micro Devices X86-64" in header


def test_it_needs_only_what_every_android_has(device_library: Path) -> None:
    dynamic = run("readelf", "--wide", "--dynamic", device_library)
    needed = set(re.findall(r"\(NEEDED\).*\[(.*)]", dynamic))
    assert needed <= {"libc.so", "libm.so", "libdl.so", "liblog.so"}
    assert re.findall(r"\(SONAME\).*\[(.*)]", dynamic) == ["libml2sensors.so"]
    assert "TEXTREL" not in dynamic


def test_it_exports_the_documented_interface_and_nothing_else(device_library: Path) -> None:
    header = (ROOT / "native" / "sdk" / "ml2s.h").read_text()
    declared = set(re.findall(r"^ML2S_API .*?(ml2s_\w+)\(", header, re.MULTILINE))
    exported, _ = symbols(device_library)
    assert exported == declared | {"JNI_OnLoad"}


def test_it_imports_nothing_but_what_bionic_and_glibc_share(device_library: Path) -> None:
    _, imported = symbols(device_library)
    assert imported <= IMPORTS

"""The library in the packages is the one that was linked, which native/device/check.sh has seen."""

from __future__ import annotations

from toolchain import ROOT, Package, run


def test_it_is_the_one_that_was_linked(package: Package) -> None:
    packed = package.folder / "jni" / "x86_64" / "libml2sensors.so"
    linked = ROOT / "build" / "native" / "device" / "libml2sensors.so"
    assert packed.read_bytes() == linked.read_bytes()


def test_it_needs_and_shows_nothing_unexpected() -> None:
    """Libraries needed, symbols imported and exported."""
    assert run(ROOT / "native" / "device" / "check.sh") == ""

"""The two packages of `make aar`, unpacked."""

from pathlib import Path

import pytest

from toolchain import ROOT, Package, jar, kotlinc, runtime_libraries, unpack


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Package:
    return unpack("ml2-sensors", tmp_path_factory.mktemp("library"), runtime_libraries())


@pytest.fixture(scope="session")
def unity(tmp_path_factory: pytest.TempPathFactory) -> Package:
    """It needs nothing beside it."""
    return unpack("ml2-sensors-unity", tmp_path_factory.mktemp("unity"), [])


@pytest.fixture(params=["library", "unity"])
def package(request: pytest.FixtureRequest) -> Package:
    chosen: Package = request.getfixturevalue(request.param)
    return chosen


@pytest.fixture(scope="session")
def sample(library: Package, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sample app, compiled against what the package holds."""
    sources = ROOT / "ml2-sensors-aar" / "sample" / "src" / "main" / "kotlin"
    app = tmp_path_factory.mktemp("sample") / "sample.jar"
    kotlinc(app, sources, class_path=[library.classes, *library.libraries, jar("android-all")])
    return app

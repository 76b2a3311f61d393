"""The app made once more of the same inputs: elsewhere on earth and disk, and signed by another."""

import filecmp
import shutil
from pathlib import Path

import pytest

from apk import APK
from toolchain import ELSEWHERE, PACKAGES, ROOT, jar, java, maven_property, run, runtime_libraries

APP = Path("ml2-sensors-aar/app")
UNSIGNED = APP / "target" / "made" / "unsigned.apk"
VERSION = maven_property("revision")
PASSWORD = "not a secret"


@pytest.fixture(scope="module")
def keystore(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("key") / "own.keystore"
    key = ["-alias", "own", "-keyalg", "EC", "-groupname", "secp256r1", "-dname", "CN=Own"]
    run("keytool", "-genkeypair", *key, "-keystore", file, "-storepass", PASSWORD)
    return file


@pytest.fixture(scope="module")
def again(tmp_path_factory: pytest.TempPathFactory, keystore: Path) -> Path:
    """The root of a copy in which package.xml has run."""
    root = tmp_path_factory.mktemp("again")
    shutil.copytree(ROOT / APP, root / APP, ignore=shutil.ignore_patterns("target"))
    code = ROOT / APP / "target" / f"ml2-sensors-app-{VERSION}.jar"
    for source in [code, PACKAGES / f"ml2-sensors-{VERSION}.aar"]:
        copy = root / source.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, copy)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("KEYSTORE_PASSWORD", PASSWORD)
        package(root / APP / "package.xml", keystore)
    return root


def package(script: Path, keystore: Path) -> None:
    """Runs it as Maven does, with the properties that Maven gives it."""
    properties = {f"{group_of(path)}:{name_of(path)}:jar": str(path) for path in inputs()}
    properties |= {"revision": VERSION, "version.code": "1"}
    properties |= {"keystore": str(keystore), "keystore.password": "env:KEYSTORE_PASSWORD"}
    options = [f"-D{name}={value}" for name, value in properties.items()]
    ant = ["org.apache.tools.ant.Main", "-q", "-f", str(script)]
    java([jar("ant"), jar("ant-launcher")], *ELSEWHERE, *ant, *options, "resources", "apk")


def inputs() -> list[Path]:
    return [jar("r8"), jar("android-all"), *runtime_libraries()]


def name_of(artifact: Path) -> str:
    return artifact.parents[1].name


def group_of(artifact: Path) -> str:
    """Returns the group, from the path GROUP/NAME/VERSION/FILE in Maven's local repository."""
    parts = artifact.parts[artifact.parts.index("repository") + 1 : -3]
    return ".".join(parts)


def test_the_same_inputs_make_the_same_bytes_but_for_the_signature(again: Path) -> None:
    assert filecmp.cmp(again / UNSIGNED, ROOT / UNSIGNED, shallow=False)


def test_a_key_of_ones_own_signs(again: Path) -> None:
    signed = again / APK.relative_to(ROOT)
    assert "certificate DN: CN=Own" in run("apksigner", "verify", "--print-certs", signed)

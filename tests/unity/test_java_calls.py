"""Java's classes and methods that C# calls by name."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
CALL = re.compile(r'\.Call(?:Static)?(?:<\w+>)?\("(\w+)"')
CLASS = re.compile(r'new AndroidJavaClass\("([\w.]+)"\)')


def _sources() -> dict[str, str]:
    package = ROOT / "unity_package"
    files = [file for folder in ("Runtime", "OpenXR") for file in (package / folder).rglob("*.cs")]
    return {file.name: file.read_text() for file in files}


def test_csharp_calls_only_methods_that_the_facade_has() -> None:
    facade = (ROOT / "ml2-sensors-aar/src/main/kotlin/dev/ml2sensors/unity/Ml2Unity.kt").read_text()
    public = set(re.findall(r"^ +fun (\w+)\(", facade, re.MULTILINE))
    called = {name for text in _sources().values() for name in CALL.findall(text)}
    assert {"open", "start", "close", "loadLibrary"} <= called
    assert called <= public


def test_csharp_calls_no_class_of_the_system_which_would_look_for_our_library_elsewhere() -> None:
    """System.loadLibrary searches where its caller does: for a native thread, in the system."""
    classes = {name for text in _sources().values() for name in CLASS.findall(text)}
    assert classes == {"com.unity3d.player.UnityPlayer", "dev.ml2sensors.unity.Ml2Unity"}

"""Sources in C#: the names of Java that they call, and the examples in the documents."""

import re

from document import ROOT, blocks, without_spacing

PACKAGE = ROOT / "unity_package"
CALL = re.compile(r'\.Call(?:Static)?(?:<\w+>)?\("(\w+)"')
CLASS = re.compile(r'new AndroidJavaClass\("([\w.]+)"\)')


def _sources() -> dict[str, str]:
    files = [file for folder in ("Runtime", "OpenXR") for file in (PACKAGE / folder).rglob("*.cs")]
    return {file.name: file.read_text() for file in files}


def test_csharp_calls_only_methods_that_the_facade_has() -> None:
    folder = ROOT / "ml2-sensors-aar/src/main/kotlin/dev/ml2sensors/unity"
    facade = "".join(it.read_text() for it in folder.glob("*.kt"))
    public = set(re.findall(r"^ +fun (\w+)\(", facade, re.MULTILINE))
    called = {name for text in _sources().values() for name in CALL.findall(text)}
    assert {"open", "start", "close", "loadLibrary", "subscribe"} <= called
    assert called <= public


def test_csharp_calls_no_class_of_the_system_which_would_look_for_our_library_elsewhere() -> None:
    """System.loadLibrary searches where its caller does: for a native thread, in the system."""
    classes = {name for text in _sources().values() for name in CLASS.findall(text)}
    assert classes == {"com.unity3d.player.UnityPlayer", "dev.ml2sensors.unity.Ml2Unity"}


def test_the_examples_in_the_documents_are_in_a_file_that_was_compiled() -> None:
    source = PACKAGE / "Tests/Mono~/DocumentedExamples.cs"
    compiled = without_spacing(source.read_text())
    documents = [PACKAGE / "README.md", PACKAGE / "Documentation~/index.md"]
    code = [text for document in documents for text in blocks(document.read_text(), "csharp")]
    assert len(code) == 4
    assert [text for text in code if without_spacing(text) not in compiled] == []

"""The examples of README.md are lines of files that other tests compile.

`tests/aar` compiles the Kotlin, `tests/unity/run.sh` the C#; the receiver has a test of the Python.
"""

from __future__ import annotations

import pytest

from document import ROOT, blocks, without_spacing

COMPILED = {
    "kotlin": "ml2-sensors-aar/sample/src/main/kotlin/dev/ml2sensors/sample/ReadmeExamples.kt",
    "csharp": "unity_package/Tests/Mono~/DocumentedExamples.cs",
}


@pytest.mark.parametrize("language", COMPILED)
def test_each_line_of_the_example_is_compiled(language: str) -> None:
    compiled = {
        without_spacing(line) for line in (ROOT / COMPILED[language]).read_text().splitlines()
    }
    (example,) = blocks((ROOT / "README.md").read_text(), language)
    lines = example.splitlines()
    assert len(lines) == 5
    assert [line for line in lines if without_spacing(line) not in compiled] == []

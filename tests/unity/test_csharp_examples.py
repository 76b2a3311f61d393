"""Tests that the C# examples in the package's documents are in a file that run.sh compiles."""

from __future__ import annotations

from document import ROOT, blocks, without_spacing

PACKAGE = ROOT / "unity_package"


def test_the_examples_were_compiled() -> None:
    source = PACKAGE / "Tests/Mono~/DocumentedExamples.cs"
    compiled = without_spacing(source.read_text())
    documents = [PACKAGE / "README.md", PACKAGE / "Documentation~/index.md"]
    code = [text for document in documents for text in blocks(document.read_text(), "csharp")]
    assert len(code) == 2
    assert [text for text in code if without_spacing(text) not in compiled] == []

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from ml2_receiver.errors import RosError
from ml2_receiver.printable import MOST_CHARACTERS, printable
from ml2_tools.monitoring.topic_table import topic_table

# Writes the clipboard of some terminals.
CLIPBOARD = "\x1b]52;c;aGVsbG8=\x07"


@given(st.text(), st.integers(4, 100))
def test_what_is_left_is_printable_and_bounded(text: str, most: int) -> None:
    shown = printable(text, most)
    assert shown.isprintable()
    assert len(shown) <= most


@given(st.text(st.characters(categories=["L", "N", "P", "S"]), max_size=MOST_CHARACTERS))
def test_printable_text_stays_as_it_is(text: str) -> None:
    assert printable(text) == text


def test_errors_say_nothing_to_a_terminal() -> None:
    said = str(RosError(f"one\n{CLIPBOARD}{'x' * 60_000}"))
    assert said.startswith("one\n\\x1b]52;c;aGVsbG8=\\x07xx")
    assert len(said) <= 2000


@pytest.mark.parametrize("name", ["Lab [/x]", "[bold", "[link=https://example.com]here[/link]"])
def test_a_headset_may_have_any_printable_name(name: str) -> None:
    topic = {"type": "a", "stream": "b", "message": f"of {name}", "gaps": "0", "unpublished": "0"}
    table = topic_table({"session": {"message": f"connected to {name}"}, f"/x/{name}": topic})
    output = io.StringIO()
    Console(file=output, width=200).print(table)
    assert f"connected to {name}" in output.getvalue()
    assert f"/x/{name}" in output.getvalue()
    assert f"of {name}" in output.getvalue()

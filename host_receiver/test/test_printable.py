import io
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from ml2_receiver import errors as errors_module
from ml2_receiver.errors import ReceiverError, RosError
from ml2_receiver.printable import MOST_CHARACTERS, printable
from ml2_receiver.table.reader import load_table
from ml2_tools import errors as _  # noqa: F401, whose errors are tried too
from ml2_tools.commands import devices, doctor, headset
from ml2_tools.commands.reading import say_left_out
from ml2_tools.doctor.devices import Device, read_device
from ml2_tools.doctor.findings import Finding
from ml2_tools.headset.app import AppStatus, StreamStatus
from ml2_tools.inspection.check import Check
from ml2_tools.inspection.table import integrity_table, problems
from ml2_tools.monitoring.latency_table import latency_table
from ml2_tools.monitoring.losses import Losses
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
    output = io.StringIO()
    console = Console(file=output, width=200)
    rows = {"session": {"message": f"connected to {name}"}, f"/x/{name}": topic}
    console.print(topic_table(rows, console))
    assert f"connected to {name}" in output.getvalue()
    assert f"/x/{name}" in output.getvalue()
    assert f"of {name}" in output.getvalue()


def errors() -> list[type[ReceiverError]]:
    found = [ReceiverError]
    for it in found:
        found += [each for each in it.__subclasses__() if each not in found]
    return found


@pytest.mark.parametrize("error", errors(), ids=lambda it: it.__name__)
def test_no_error_is_long_or_speaks_to_a_terminal(error: type[ReceiverError]) -> None:
    foreign = CLIPBOARD + "x" * 60_000
    match error:
        case errors_module.ConfigError:
            problem = errors_module.Problem(1, foreign, foreign, foreign)
            raised: ReceiverError = errors_module.ConfigError([problem] * 100, foreign)
        case errors_module.ProtocolError:
            raised = errors_module.ProtocolError(errors_module.ErrorCode.MALFORMED, foreign)
        case _:
            raised = error(foreign, hint=foreign)
    for said in (str(raised), raised.hint, raised.in_one_line()):
        assert len(said) <= MOST_CHARACTERS
        assert said.replace("\n", "").isprintable()
    assert str(raised)


HOSTILE_NAME = f"/x{CLIPBOARD}[/x][link=https://example.com]{'y' * 60_000}"


def shown(table: Any) -> str:
    output = io.StringIO()
    Console(file=output, width=9000).print(table)
    return output.getvalue()


def hostile_device() -> Device:
    """A headset as another node may describe one: each word is hostile."""
    table = load_table()
    session = dict.fromkeys(("device_id", "headset", "state", "software"), HOSTILE_NAME)
    session |= {f"state.{id}": HOSTILE_NAME for id in table.streams}
    session[f"permission.{HOSTILE_NAME}"] = "true"
    device = read_device({"session": session}, table)
    assert device is not None
    return device


def test_tables_show_names_of_recordings_and_of_other_nodes_as_text() -> None:
    check = Check(HOSTILE_NAME, "messages", "wrong", HOSTILE_NAME, {"messages": 1})
    topic = {"type": "a", "stream": HOSTILE_NAME, "message": HOSTILE_NAME}
    rows = {"session": {"message": HOSTILE_NAME}, HOSTILE_NAME: topic}
    said = [
        shown(integrity_table([check])),
        *map(shown, problems([check])),
        shown(topic_table(rows, Console(width=80))),
        shown(latency_table({HOSTILE_NAME: (HOSTILE_NAME, None)}, 1)),
        shown(devices._headset(hostile_device())),
        shown(doctor._table([Finding("", "ok", HOSTILE_NAME, HOSTILE_NAME)])),
    ]
    for it in said:
        assert "\x1b" not in it
        assert "\x07" not in it
        assert "[/x]" in it
        assert "y" * 2001 not in it


def test_words_of_the_app_on_the_headset_are_shown_as_text(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "9000")
    name = HOSTILE_NAME
    status = AppStatus(name, "ended", name, name, name, [], {name: True}, False, False)
    headset._show(status, [StreamStatus(HOSTILE_NAME, "failed", HOSTILE_NAME, 1, 0, False)])
    said = capsys.readouterr().out
    assert said.count("[/x]") == 4  # in the title, which is cut, and in three cells
    assert "\x1b" not in said


def test_what_is_left_out_of_a_recording_is_said_as_text(
    capsys: pytest.CaptureFixture[str],
) -> None:
    losses = Losses()
    losses.add(HOSTILE_NAME)
    say_left_out([HOSTILE_NAME, *losses.counts()])
    for line in capsys.readouterr().err.splitlines():
        assert line.isprintable()
        assert len(line) <= MOST_CHARACTERS + len("left out: ")


# Characters that reverse text, hide, or begin a new line for some readers.
HIDDEN = "\u202e\u2066\u200b\u200d\u00ad\ufeff\u2028\u0085\u009b\ue000\U000e0041\x7f"


def test_text_that_reverses_or_hides_is_shown_as_escapes() -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    from std_msgs.msg import String

    from ml2_tools.monitoring.topic_reader import as_text

    assert all(printable(it).startswith("\\") for it in HIDDEN)
    said = as_text(String(data=f"a{HIDDEN}{CLIPBOARD}{'x' * 100_000}"))
    assert said.removesuffix("\n").isprintable()
    assert "\\u202e" in said
    assert len(said) < 70_000


def test_only_one_place_writes_json_for_others() -> None:
    """The wire and the files of this receiver have checked values."""
    root = Path(__file__).parents[1]
    own = {"json_text.py", "json_body.py", "configuration.py", "paired_devices.py", "settings.py"}
    files = (file for top in ("ml2_receiver", "ml2_tools") for file in (root / top).rglob("*.py"))
    assert {it.name for it in files if "json.dumps(" in it.read_text("utf-8")} <= own

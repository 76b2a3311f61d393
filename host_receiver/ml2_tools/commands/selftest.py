"""ml2-receiver headset selftest: judges what is assumed about the headset."""

import argparse
import dataclasses
import socket
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.table import Table

from ml2_receiver.commands.options import Subparsers, add_file
from ml2_receiver.configuration.config_file import ConfigFile
from ml2_receiver.errors import ReceiverError
from ml2_receiver.json_text import json_text
from ml2_receiver.printable import markup

from ..headset import app
from ..headset.adb import adb
from ..selftest.sessions import SECONDS, STEPS, record_step, temporary_folder
from ..selftest.simulated import simulated_headset
from ..selftest.verdict import Verdict, as_objects
from .optional_packages import optional_packages
from .set import value_of

# A value that is so many times the tolerated distance away is not by chance.
_CERTAIN_MARGIN = 5.0
_MARKS = {"as assumed": "[green]as assumed[/]", "differs": "[red]differs[/]"}
_EPILOG = """\
Records four sessions of 6 to 10 s, and judges by them what this program assumes about the headset;
docs/unconfirmed.md has the list. Nobody has to do anything; with the headset on a turning head it
finds out more. The report is written after each step, so that Ctrl-C keeps what was found. It has
no images, keys, addresses or serial numbers.

Exit code: 0; 1 when a fact differs; 2 with the reason.

examples:
  ml2-receiver headset selftest
  ml2-receiver headset selftest --skip openxr --apply
  ml2-receiver headset selftest --read selftest-2026-11-28.zip
  ml2-receiver headset selftest --simulated assume.null_buffers=0
"""


def add_selftest(actions: Subparsers) -> None:
    parser = actions.add_parser(
        "selftest", help="find out in a minute what of the headset is as assumed", epilog=_EPILOG
    )
    add_file(parser, "--read", metavar="ZIP", help="show the verdicts of a report")
    parser.add_argument(
        "--simulated",
        nargs="*",
        metavar="KEY=VALUE",
        help="test a simulated headset, which is started, with these values",
    )
    add_file(
        parser, "--out", metavar="ZIP", help="the report; default: selftest-DATE.zip, made anew"
    )
    parser.add_argument(
        "--skip", action="append", default=[], choices=STEPS, help="leave a step out"
    )
    parser.add_argument(
        "--apply",
        action="store_true",
        help="write to your config.yaml what a fact that clearly differs asks for",
    )
    parser.add_argument("--json", action="store_true", help="print a list of objects")
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.read is not None:
        others = {"--apply": options.apply, "--simulated": options.simulated is not None}
        if given := [it for it, is_given in others.items() if is_given]:
            raise ReceiverError(f"{given[0]} is for a test, and --read only shows one")
    with optional_packages(
        "cv2", command="headset selftest", pip="pip install './host_receiver[products]'"
    ):
        from ..selftest.report import read_verdicts
    verdicts = _test(options) if options.read is None else read_verdicts(options.read)
    if options.json:
        print(json_text(as_objects(verdicts), indent=2))
    else:
        Console().print(_table(verdicts))
    if options.apply:
        apply(verdicts)
    return int(any(it.verdict == "differs" for it in verdicts))


def _test(options: argparse.Namespace) -> list[Verdict]:
    from ..selftest.evidence import Evidence, SessionStreams, read_session
    from ..selftest.judge import judge
    from ..selftest.report import names_of, numbers_of, write_report

    file = options.out or Path(f"selftest-{time.strftime('%Y-%m-%d')}.zip")
    steps = [it for it in STEPS if it not in options.skip]
    if not steps:
        raise ReceiverError(f"expected a step of {', '.join(STEPS)}, found all skipped")
    sessions: list[SessionStreams] = []
    verdicts: list[Verdict] = []
    names = {socket.gethostname()}
    data = b""
    with temporary_folder() as folder, _headset(options, folder) as it:
        receiver_options, read_log, own_names, is_running = it
        for number, step in enumerate(steps, 1):
            words = f"{number} of {len(steps)}: {step}"
            with Console(stderr=True).status(f"{words}, {SECONDS[step]:.0f} s"):
                try:
                    walk = record_step(step, folder, receiver_options, is_running)
                except ReceiverError as error:
                    if is_running():
                        raise
                    last = next(reversed(read_log()), "it said nothing")
                    raise ReceiverError(f"the simulated headset has ended: {last}") from error
                sessions.append(read_session(walk))
                data = data or numbers_of(walk)
                names |= {*own_names, *names_of(walk)}
                is_real = options.simulated is None
                evidence = Evidence(sessions, read_log(), True, is_behind_adb=is_real)
                verdicts = judge(evidence)
                write_report(file, verdicts, evidence, data, names)
            counts = Counter(it.verdict for it in verdicts)
            found = ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items()))
            print(f"{words}: {found}", file=sys.stderr, flush=True)
    print(f"wrote {file}: attach it to an issue", file=sys.stderr)
    return verdicts


type _Log = Callable[[], Sequence[str]]


@contextmanager
def _headset(
    options: argparse.Namespace, folder: Path
) -> Iterator[tuple[Sequence[str], _Log, Sequence[str], Callable[[], bool]]]:
    """Yields the recorder's options, what reads the headset's log, what nobody may read there, and
    what returns False when the headset has ended."""
    if options.simulated is not None:
        with simulated_headset(folder, options.simulated) as (receiver, log, is_running):
            yield receiver, lambda: log.read_text(errors="replace").splitlines(), (), is_running
        return
    serial = adb("get-serialno").strip()
    app.start()

    def read_log() -> Sequence[str]:
        return adb("logcat", "-d", "-v", "time", "-s", "ml2s").splitlines()

    yield (), read_log, (serial,), lambda: True


def _table(verdicts: Sequence[Verdict]) -> Table:
    table = Table("fact", "verdict", "found", "a key to try", box=None)
    for it in verdicts:
        is_text = it.measured is None or isinstance(it.measured, str)
        found = it.measured or "" if is_text else f"{it.measured:.4g}"
        table.add_row(
            markup(it.fact),
            _MARKS.get(it.verdict, markup(it.verdict)),
            markup(f"{found} {it.unit}".strip()),
            markup(it.switch if it.verdict == "differs" else ""),
        )
    return table


def apply(verdicts: Sequence[Verdict]) -> None:
    """Sets the switches of facts that differ beyond doubt in the user's file."""
    certain = [it.switch for it in verdicts if _is_certain(it) and it.switch]
    if not certain:
        print("nothing to apply: no fact with a key differs beyond doubt")
        return
    file = ConfigFile.of_user()
    config = file.load()
    pairs = (it.partition("=") for it in certain)
    changed = {key: value_of(key, text) for key, _, text in pairs}
    file.save(dataclasses.replace(config, values={**config.values, **changed}))
    for it in certain:
        print(f"set {it} in {file.path}")


def _is_certain(verdict: Verdict) -> bool:
    """Returns True if it differs by far, or by what the headset itself has said."""
    margin = _CERTAIN_MARGIN if verdict.margin is None else verdict.margin
    return verdict.verdict == "differs" and margin >= _CERTAIN_MARGIN

"""`make demo`: a headset without a headset, the receiver and an independent observer, live."""

import argparse
import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO, Any

from rich.console import Console

from left_out import left_out, words
from live_table import LiveTable
from ml2_receiver.commands.options import above_zero
from ml2_receiver.commands.stopping import heed_interrupts
from ml2_receiver.configuration.config import load_config
from ml2_receiver.errors import ConfigError, ReceiverError
from ml2_receiver.table.reader import load_table
from ml2_tools.selftest.pairing import accept, offered
from report import build_report, verdict
from shaped_link import Machine, link, why_not

ROOT = Path(__file__).resolve().parents[2]
RECEIVER = ROOT / "host_receiver" / "ml2-receiver"
HEADSET = ROOT / "ml2-sensors-aar" / "simulator" / "ml2-headset"
OUTPUT = ROOT / "build" / "demo"
_LISTENING = "listening on "
_STARTING = "starting; `host_receiver/ml2-receiver view` shows more, in a second terminal"
_WIDTH = 150
# The first demo draws images while it streams them: as few as there can be.
_LOOP_S = 2


def main() -> int:
    """Runs the demo; 0 only if every accepted stream arrived."""
    arguments = _parse()
    console = Console(record=True, width=None if sys.stdout.isatty() else _WIDTH)
    try:
        prefix = load_config(arguments.config).prefix
    except ConfigError as error:
        console.print(str(error), style="red", markup=False)
        return 2
    # The demo stays on this machine unless the user has chosen otherwise.
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    OUTPUT.mkdir(parents=True, exist_ok=True)
    print(_STARTING, file=sys.stderr, flush=True)
    with ExitStack() as stack:
        near, far = _hosts(stack, arguments.link)
        keys = Path(stack.enter_context(TemporaryDirectory()))
        own: list[str | Path] = ["--keys", keys / "receiver"]
        simulator: list[str | Path] = [HEADSET, "--keys", keys / "headset"]
        receive = [*near.prefix, RECEIVER, *_receiver_options(arguments, near.address), *own]
        observe = [*near.prefix, *_observer_command(prefix)]
        with offered([RECEIVER, "pair", *own]) as uri:
            # They start while the headset's first program does, which only pairs.
            receiver = stack.enter_context(_process("receiver", receive))
            observer = stack.enter_context(_process("observer", observe))
            accept(simulator, uri)
        address = _address(receiver)
        simulate = [*far.prefix, *simulator, *_headset_options(arguments, address)]
        headset = stack.enter_context(_process("headset", simulate, is_read=False))
        threading.Thread(target=_end_after_failure, args=[headset, observer], daemon=True).start()
        final = _watch(console, observer, prefix, "replay" if arguments.replay else "simulated")
    if final is None:
        console.print(f"a process ended early; their words are in {OUTPUT}/*.log", style="red")
        return 1
    report = build_report(final, "replay" if arguments.replay else "simulated")
    (OUTPUT / "report.json").write_text(json.dumps(report, indent=2) + "\n")
    failures = verdict(final, is_simulated=arguments.replay is None)
    for failure in failures:
        console.print(failure, style="red", markup=False)
    console.save_svg(str(OUTPUT / "table.svg"), title="make demo", clear=False)
    console.print(f"report: {OUTPUT / 'report.json'}\npictures: {OUTPUT / 'streams.png'}")
    return 1 if failures else 0


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="make demo")
    parser.add_argument("--duration", type=float, default=15.0, help="seconds of simulated sensors")
    parser.add_argument("--config", type=Path, default=ROOT / "config" / "demo.yaml")
    parser.add_argument("--replay", type=Path, help="an EuRoC/ASL folder instead of the simulation")
    parser.add_argument(
        "--link", type=above_zero, metavar="MBIT", help="between headset and receiver; needs root"
    )
    return parser.parse_args()


def _hosts(stack: ExitStack, link_mbit: float | None) -> tuple[Machine, Machine]:
    """The hosts of receiver and headset: this machine, or both ends of a link."""
    if link_mbit is None:
        return Machine(), Machine()
    if reason := why_not():
        hint = f"; try: sudo make demo LINK={link_mbit:g}" if os.geteuid() != 0 else ""
        raise SystemExit(f"no link of {link_mbit:g} Mbit/s: {reason}{hint}")
    made = stack.enter_context(link("cubic", link_mbit))
    return made.receiver, made.headset


def _receiver_options(arguments: argparse.Namespace, host: str) -> list[str | Path]:
    return ["run", "--config", str(arguments.config), "--listen", f"{host}:0", "--start-paused"]


def _headset_options(arguments: argparse.Namespace, address: str) -> list[str | Path]:
    if arguments.replay:
        return ["--receiver", address, "--replay", str(arguments.replay)]
    duration = ["--duration", str(arguments.duration)]
    return ["--receiver", address, *duration, "--simulate", f"loop_seconds={_LOOP_S}"]


def _observer_command(prefix: str) -> list[str | Path]:
    depths = {name: qos.depth for name, qos in load_table().qos.items()}
    script = Path(__file__).with_name("observer.py")
    pictures = OUTPUT / "streams.png"
    pictures.unlink(missing_ok=True)
    return [
        *(sys.executable, script, "--prefix", prefix),
        *("--qos-depths", json.dumps(depths), "--pictures", pictures),
    ]


@contextmanager
def _process(
    name: str, command: list[str | Path], is_read: bool = True
) -> Iterator[subprocess.Popen[str]]:
    """A child, terminated and awaited at the end; unread output goes to build/demo/<name>.log."""
    with (OUTPUT / f"{name}.log").open("w") as log:
        stdout = subprocess.PIPE if is_read else log
        words = [str(word) for word in command]
        child = subprocess.Popen(words, stdout=stdout, stderr=log, text=True)
        try:
            yield child
        finally:
            _end(child)


def _end_after_failure(headset: subprocess.Popen[str], observer: subprocess.Popen[str]) -> None:
    """There is nothing to observe when the headset cannot go on."""
    if headset.wait() != 0:
        observer.kill()


def _end(child: subprocess.Popen[str]) -> None:
    child.terminate()
    try:
        child.wait(timeout=10)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


def _address(receiver: subprocess.Popen[str]) -> str:
    for line in _lines(receiver):
        if _LISTENING in line:
            return line.split(_LISTENING, 1)[1].split()[0]
    raise SystemExit(f"the receiver did not start; its words are in {OUTPUT / 'receiver.log'}")


def _watch(
    console: Console, observer: subprocess.Popen[str], prefix: str, source: str
) -> dict[str, Any] | None:
    """Shows the observer's snapshots up to the final one, which it returns; None if none comes."""
    with LiveTable(console, prefix, source) as table:
        for line in _lines(observer):
            snapshot: dict[str, Any] = json.loads(line)
            table.show(snapshot, words(left_out(OUTPUT / "headset.log")))
            if snapshot["final"]:
                return snapshot
    return None


def _lines(child: subprocess.Popen[str]) -> IO[str]:
    assert child.stdout is not None
    return child.stdout


if __name__ == "__main__":
    heed_interrupts()
    try:
        sys.exit(main())
    except ReceiverError as error:
        sys.exit(str(error))
    except KeyboardInterrupt:
        sys.exit(130)  # as shells say of SIGINT

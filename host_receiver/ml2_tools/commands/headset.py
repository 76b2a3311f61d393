"""ml2-receiver headset: the app on the headset, commanded over adb."""

import argparse
import dataclasses
import time
from collections.abc import Collection, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from rich.console import Console
from rich.table import Table

from ml2_receiver.commands.options import STREAMS, Subparsers, add_file, complete, port
from ml2_receiver.commands.session_port import PORT
from ml2_receiver.generated.version import VERSION
from ml2_receiver.json_text import json_text
from ml2_receiver.pairing.uri import PairingUri
from ml2_receiver.pairing.uri_source import uri_of
from ml2_receiver.printable import markup
from ml2_receiver.table.reader import load_table

from ..errors import AdbError
from ..headset import app
from ..headset.adb import adb
from .selftest import add_selftest

_APK = Path(__file__).parents[3] / "build" / "apk" / f"ml2-sensors-{VERSION}.apk"
_INSTALL_TIMEOUT_S = 180.0
_CONNECT_TIMEOUT_S, _POLL_S = 10.0, 0.5
_EPILOG = """\
Needs adb (`sudo apt install adb`) and a headset on the cable; among several devices adb's own
variable ANDROID_SERIAL chooses. Exit code: 0; 1 when `start` did not connect; 2 with the reason.

examples:
  ml2-receiver headset install
  ml2-receiver headset grant                          all permissions that streams need
  ml2-receiver headset start --pair -                 pair by the URI that `ml2-receiver pair` shows
  ml2-receiver pair | ml2-receiver headset start --pair -     the same, and nobody sees it
  ml2-receiver headset start --usb                    by the cable alone, without a network
  ml2-receiver headset status --json | jq .status.state
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "headset", help="install, start and watch the headset's app over adb", epilog=_EPILOG
    )
    actions = parser.add_subparsers(required=True, metavar="ACTION")
    install = actions.add_parser("install", help="install the app, or a newer one")
    add_file(install, "apk", nargs="?", default=_APK, help="default: that of `make apk`")
    install.set_defaults(run=_install)
    _add_start(actions)
    actions.add_parser("stop", help="stop streaming").set_defaults(run=_stop)
    status = actions.add_parser("status", help="show how the app stands, and its streams")
    status.add_argument("--json", action="store_true", help="print one object")
    status.set_defaults(run=_status)
    grant = actions.add_parser("grant", help="grant the app the permissions that streams need")
    streams = grant.add_argument(
        "streams", nargs="*", metavar="STREAM", help="default: all, images of eyes too"
    )
    complete(streams, STREAMS)
    grant.set_defaults(run=_grant)
    add_selftest(actions)


def _add_start(actions: Subparsers) -> None:
    start = actions.add_parser("start", help="stream, whichever app is in front")
    start.add_argument(
        "--pair",
        metavar="-|FILE|URI",
        help="pair first, by the URI on standard input or in a file; other users of this machine"
        " can read the words of a command",
    )
    place = start.add_mutually_exclusive_group()
    place.add_argument(
        "--receiver",
        metavar="NAME|HOST:PORT",
        help="to this one from now on; '' for the one that is paired, wherever it is",
    )
    place.add_argument(
        "--usb",
        nargs="?",
        type=port,
        const=PORT,
        metavar="PORT",
        help="from now on by the cable alone, to the port where `run` listens here, by default"
        f" {PORT}; all streams share one pipe then, so that images can delay an IMU sample",
    )
    start.set_defaults(run=_start)


def _install(options: argparse.Namespace) -> int:
    if not options.apk.is_file():
        raise AdbError(
            f"there is no file {options.apk}", hint="Build it with `make apk`, or name another APK."
        )
    with _doing("installing"):
        adb("install", "-r", str(options.apk), timeout_s=_INSTALL_TIMEOUT_S)
    print("installed; next: `ml2-receiver pair | ml2-receiver headset start --pair -`")
    return 0


def _start(options: argparse.Namespace) -> int:
    uri = None if options.pair is None else uri_of(options.pair)
    if options.usb is not None:
        _reverse(options.usb)
    if uri is not None:
        with _doing("pairing"):
            app.pair(str(uri if options.usb is None else _by_cable(uri)))
    if options.usb is not None:
        app.go_to(f"127.0.0.1:{options.usb}")
    elif options.receiver is not None:
        app.go_to(options.receiver)
    app.start()
    with _doing("connecting"):
        status, streams = _once_connected()
    _show(status, streams)
    return 0 if status.state == "connected" else 1


def _by_cable(uri: PairingUri) -> PairingUri:
    _reverse(uri.port)
    return dataclasses.replace(uri, host="127.0.0.1")


def _reverse(port: int) -> None:
    """Forwards connections to a TCP port of the headset to the same port here."""
    adb("reverse", f"tcp:{port}", f"tcp:{port}")


def _once_connected() -> tuple[app.AppStatus, Sequence[app.StreamStatus]]:
    """Returns the state of the app when it is connected, or when the time limit is reached."""
    deadline_s = time.monotonic() + _CONNECT_TIMEOUT_S
    while True:
        status, streams = app.status()
        if status.state == "connected" or time.monotonic() > deadline_s:
            return status, streams
        time.sleep(_POLL_S)


def _stop(_: argparse.Namespace) -> int:
    app.stop()
    return 0


def _status(options: argparse.Namespace) -> int:
    status, streams = app.status()
    if options.json:
        plain = [dataclasses.asdict(it) for it in streams]
        print(json_text({"status": dataclasses.asdict(status), "streams": plain}, indent=2))
    else:
        _show(status, streams)
    return 0


def _grant(options: argparse.Namespace) -> int:
    for permission in _needed(options.streams):
        app.grant(permission)
        print(f"granted {permission}")
    if app.status()[0].state != "off":
        app.start()
    return 0


def _needed(ids: Collection[str]) -> Sequence[str]:
    """Returns the permissions that a user has to grant for the streams; without ids, for all."""
    table = load_table()
    for id in ids:
        if id not in table.streams:
            raise AdbError(f"there is no stream {id!r}, only {', '.join(table.streams)}")
    streams = [table.streams[id] for id in ids or table.streams]
    needed = [it for stream in streams for it in table.sections[stream.section].permissions]
    return [it for it in dict.fromkeys(needed) if table.permissions[it] == "dangerous"]


def _show(status: app.AppStatus, streams: Sequence[app.StreamStatus]) -> None:
    table = Table("stream", "state", title=markup(_title(status)), title_justify="left", box=None)
    table.add_column("produced", justify="right")
    table.add_column("lost", justify="right")
    table.add_column("why")
    for it in streams:
        state = "resting, hot" if it.resting else it.state
        table.add_row(markup(it.id), state, str(it.produced), str(it.dropped), markup(it.reason))
    for name, is_granted in status.permissions.items():
        table.add_row(markup(name), "granted" if is_granted else "not granted")
    Console().print(table)


def _title(status: app.AppStatus) -> str:
    words = [f"ML2 Sensors {status.version}", " ".join((status.state, status.receiver)).strip()]
    words += [it for it in (status.reason, status.news) if it]
    if status.clock is not None:
        words.append(f"clock ±{status.clock.uncertainty_ns / 1e6:.2f} ms")
    if status.thermal is not None:
        words.append(f"heat {status.thermal}")
    if status.battery_celsius is not None:
        words.append(f"battery {status.battery_celsius:.1f} °C")
    if not status.paired:
        words.append("paired with nobody")
    return ", ".join(words)


def _doing(text: str) -> AbstractContextManager[object]:
    """Says so on stderr, where somebody looks."""
    return Console(stderr=True).status(text)

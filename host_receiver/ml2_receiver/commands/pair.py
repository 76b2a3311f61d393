"""ml2-receiver pair: lets a headset connect from now on."""

import argparse
import math
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import segno
from rich.live import Live

from ..errors import PairingError
from ..pairing.open_pairing import OpenPairing
from ..pairing.pairing import VALID_S
from ..pairing.uri import PairingUri
from ..security.paired_devices import PairedDevice
from ..session.event_limit import EventLimit
from ..transport.listener import everywhere
from .options import Subparsers, name, port
from .receiving import address
from .session_port import PORT, add_keys
from .stopping import stop_signal

_EVERYWHERE = everywhere(0)
_POLL_S = 0.2
# Unpaired peers must not make the code scroll away.
_LINES_PER_S = 2
_EPILOG = """\
Shows a URI for one device, for five minutes; `ml2-receiver headset start --pair -` reads it and
brings it to the headset's app by a cable, and it can be pasted there. Whoever sees it can pair, so
show it to nobody else: not as a word of a command, which other users of this machine can read. It
works with or without a receiver that runs, and one that runs lets the device in at once.

Exit code: 0 when a device was paired, else 2.

examples:
  ml2-receiver pair | ml2-receiver headset start --pair -      by a cable
  ml2-receiver pair                          then `headset start --pair -` in another terminal
  ml2-receiver pair --listen 127.0.0.1:0     for a simulated headset: ml2-headset --pair -
  ml2-receiver pair --port 7756              for `run --listen 0.0.0.0:7756`
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "pair", help="show a URI with which a headset may connect", epilog=_EPILOG
    )
    parser.add_argument(
        "--listen",
        type=address,
        default=_EVERYWHERE,
        metavar="HOST:PORT",
        help="for pairing only; default: all interfaces, on a port the system chooses",
    )
    parser.add_argument(
        "--port", type=port, default=PORT, help=f"where `run` listens; default: {PORT}"
    )
    parser.add_argument("--name", type=name, default="", help="of the receiver, where that has one")
    add_keys(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    pairing = OpenPairing(
        options.listen, options.keys, options.name, options.port, failed_attempts()
    )
    try:
        _show(pairing.uris)
        device = _wait(pairing, stopping)
    finally:
        pairing.close()
    print(f"paired with {device.name!r}, fingerprint {device.fingerprint}")
    return 0


def failed_attempts() -> Callable[[str], None]:
    """Returns a function that prints failed attempts to pair, at most two per second."""
    return EventLimit(_warn, time.monotonic, per_second=_LINES_PER_S).say


def _warn(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def _show(uris: Sequence[PairingUri]) -> None:
    first, *others = uris
    if sys.stdout.isatty():
        print("By a cable, from another terminal:\n")
        print("  ml2-receiver headset start --pair -\n")
        print("and paste the last line there, or into the app. For apps that read QR codes:\n")
        segno.make_qr(str(first), error="l").terminal(compact=True)
    print(first, flush=True)
    if not sys.stdout.isatty():  # a terminal has the time left
        print(f"valid for {VALID_S / 60:.0f} minutes, for one device", file=sys.stderr, flush=True)
    for other in others:
        print(f"this machine is {other.host}, too, for a headset on another network")


def _wait(pairing: OpenPairing, stopping: threading.Event) -> PairedDevice:
    with _countdown(pairing):
        while (device := pairing.wait(_POLL_S)) is None:
            if stopping.is_set():
                raise PairingError("no headset was paired")
    return device


@contextmanager
def _countdown(pairing: OpenPairing) -> Iterator[None]:
    if not sys.stdout.isatty():
        yield
        return
    with Live(get_renderable=lambda: _left(pairing), refresh_per_second=2, transient=True):
        yield


def _left(pairing: OpenPairing) -> str:
    minutes, seconds = divmod(math.ceil(pairing.left_s), 60)
    return f"waiting for the headset, {minutes}:{seconds:02} left"

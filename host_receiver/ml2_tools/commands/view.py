"""ml2-receiver view: shows the streams of a running receiver, or a recording, in a browser."""

from __future__ import annotations

import argparse
import os
import sys
import webbrowser
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from functools import partial
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import TYPE_CHECKING

from ml2_receiver.commands.options import Subparsers, add_receiver, port
from ml2_receiver.commands.pair import failed_attempts
from ml2_receiver.commands.ros_start import ros_needed
from ml2_receiver.commands.session_port import PORT, add_keys
from ml2_receiver.commands.stopping import stop_signal
from ml2_receiver.errors import ListenError, RecordingError
from ml2_receiver.pairing.open_pairing import OpenPairing
from ml2_receiver.transport.listener import everywhere, listen

from .live import PATIENCE_S, found_receiver
from .optional_packages import optional_packages
from .reading import add_headset, check_headset, say_apart, say_left_out

if TYPE_CHECKING:
    from ..viewing.requests import Backend
    from ..viewing.view import View

_LOOPBACK = "127.0.0.1"
_NICENESS = 5
_REDIRECT = '<meta http-equiv="refresh" content="0; url={0}"><a href="{0}">ml2-receiver view</a>'
_EPILOG = """\
Run it next to `ml2-receiver run`, or name a recording, for which neither a receiver nor ROS is
needed. The page is for browsers of this machine. The address has a secret: whoever has it can see
the images, change what the headset sends, and pair a headset.

examples:
  ml2-receiver view
  ml2-receiver view walk                     of a recording, with a time line
  ml2-receiver view --name robot1            of a receiver with that name
  ml2-receiver view --no-browser --port 8700    for `ssh -L 8700:127.0.0.1:8700`
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "view",
        help="see a receiver or a recording in a browser",
        epilog=_EPILOG,
    )
    parser.add_argument(
        "bag",
        type=Path,
        nargs="?",
        metavar="BAG",
        help="folder of a recording; default: the running receiver",
    )
    add_headset(parser)
    parser.add_argument(
        "--port", type=_port, default=0, help="0 lets the system choose; default: 0"
    )
    parser.add_argument("--no-browser", action="store_true", help="only print the address")
    parser.add_argument(
        "--eyes",
        action="store_true",
        help="offer the images of eye cameras, which are biometric data",
    )
    parser.add_argument(
        "--receiver-port",
        type=port,
        default=PORT,
        help=f"where `run` listens, for a headset that is paired on the page; default: {PORT}",
    )
    add_keys(parser)
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    with optional_packages(
        "cv2", "websockets", command="view", pip="pip install './host_receiver[view]'"
    ):
        from ..viewing.access import Token
        from ..viewing.server import ViewServer
    source = _live(options) if options.bag is None else _recorded(options)
    try:
        listener = listen((_LOOPBACK, options.port))
    except ListenError as error:
        raise ListenError(
            str(error), hint="Choose another port with --port, or leave it out."
        ) from error
    token = Token()
    address = f"http://{_LOOPBACK}:{listener.getsockname()[1]}/#{token.text}"
    with listener, source as (view, backend):
        server = ViewServer(listener, view, backend, token)
        try:
            stopping = stop_signal()
            print(f"open {address}", flush=True)
            is_shown = not options.no_browser and _has_screen()
            with _browser(address) if is_shown else nullcontext():
                stopping.wait()
        finally:
            server.close()
    return 0


@contextmanager
def _live(options: argparse.Namespace) -> Iterator[tuple[View, Backend]]:
    check_headset(options.headset)
    with ros_needed():
        from ..viewing.live_source import LiveSource  # reads the profile
        from ..viewing.receiver_backend import ReceiverBackend
    from ..viewing.pairing import PagePairing
    from ..viewing.products_beside import ProductsBeside
    from ..viewing.section_forms import section_forms
    from ..viewing.view import View

    with found_receiver(options.name, PATIENCE_S) as node:
        receiver = node.node_name(options.name, PATIENCE_S)
    # Processors that are full serve the receiver and its subscribers first: a message that wakes
    # this process interrupts nobody.
    os.nice(_NICENESS)
    if sys.platform == "linux":
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))
    source = LiveSource(options.name)
    view = View(source, options.name, options.eyes)
    pairing = PagePairing(view, lambda: _open_pairing(options))
    products = ProductsBeside(view, options.name)
    forms = section_forms(options.eyes)
    backend = ReceiverBackend(view, source.context, receiver, forms, pairing, products)
    try:
        yield view, backend
    finally:
        backend.close()
        view.close()


def _open_pairing(options: argparse.Namespace) -> OpenPairing:
    port, say = options.receiver_port, failed_attempts()
    return OpenPairing(everywhere(0), options.keys, options.name, port, say)


@contextmanager
def _recorded(options: argparse.Namespace) -> Iterator[tuple[View, Backend]]:
    from ..viewing.recorded_source import RecordedSource
    from ..viewing.view import View

    if options.name:
        raise RecordingError(
            f"--name is of a running receiver, but {options.bag} is a recording",
            hint="Leave out the one or the other.",
        )
    source = RecordedSource(options.bag, options.headset)
    say_apart(source.apart)
    say_left_out(source.left_out)
    view = View(source, source.receiver, options.eyes)
    try:
        yield view, source
    finally:
        view.close()


@contextmanager
def _browser(address: str) -> Iterator[None]:
    """Has a browser open a file that leads to the address; removes the file when left.

    Other users of this machine can read the words of a browser, but not the file.
    """
    with ExitStack() as stack:
        # Ubuntu's browsers are snaps, which can read neither /tmp nor hidden folders.
        named = partial(NamedTemporaryFile, dir=Path.home(), prefix="ml2-view-", suffix=".html")
        try:
            file = stack.enter_context(named("w"))
            file.write(_REDIRECT.format(address))
            file.flush()
        except OSError as error:
            print(f"no browser is started: {error}", file=sys.stderr, flush=True)
        else:
            webbrowser.open(Path(file.name).as_uri())
        yield


def _has_screen() -> bool:
    # Without a screen, webbrowser would start a browser for text in this terminal.
    return "DISPLAY" in os.environ or "WAYLAND_DISPLAY" in os.environ


def _port(text: str) -> int:
    return 0 if text == "0" else port(text)

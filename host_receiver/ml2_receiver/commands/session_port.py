"""The address on which headsets connect: access, listening and announcement."""

import argparse
import socket
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Self

from ..configuration.app_rules import AppRules
from ..errors import ListenError
from ..session.server import Server
from ..table.reader import load_table
from ..transport.access import Access, Everybody, PairedOnly
from ..transport.discovery import Announcement
from ..transport.listener import everywhere, listen, text
from ..user_folder import user_folder

PORT = 7755
_LOOPBACK, _EVERYWHERE = ("127.0.0.1", PORT), everywhere(PORT)
_EYE_IMAGES = "eye images are biometric: pair, or allow with --insecure-eye-images"
_INSECURE = (
    "WARNING: --insecure: no encryption, and everybody who can reach {} can send and be believed"
)


def add_keys(parser: argparse.ArgumentParser) -> None:
    """--keys."""
    parser.add_argument(
        "--keys",
        type=Path,
        default=user_folder(),
        metavar="FOLDER",
        help="with this receiver's key and the paired devices; default: ~/.config/ml2-sensors",
    )


def add_insecure(parser: argparse.ArgumentParser) -> None:
    """--insecure, and what it does not allow alone."""
    parser.add_argument(
        "--insecure",
        action="store_true",
        help="no TLS and no pairing: everybody on the network can read along and pretend to be a"
        " headset; the headset needs it too",
    )
    parser.add_argument(
        "--insecure-eye-images", action="store_true", help="with --insecure, eye images too"
    )
    parser.add_argument(
        "--insecure-control",
        action="store_true",
        help="with --insecure, app.publish, app.call and app.offer too",
    )


class SessionPort:
    """Listens, is announced, and follows who is paired, until left.

    Args:
        options: has name, keys, insecure, insecure_eye_images, insecure_control, and listen, which
            is None for the default: this machine only, and all interfaces once a device is paired.

    Raises:
        KeysError, ListenError
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self.access: Access = Everybody() if options.insecure else PairedOnly(options.keys)
        self._has_default = options.listen is None
        self.listener = listen(options.listen or self._default)
        self._allows_eye_images = not options.insecure or options.insecure_eye_images
        self._allows_control = not options.insecure or options.insecure_control
        self.name: str = options.name or socket.gethostname()
        self._lock = threading.Lock()
        self._is_closed = False
        self._announcement = self._announce()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
        self.listener.close()

    @property
    def _default(self) -> tuple[str, int]:
        return _EVERYWHERE if self.access.paired() else _LOOPBACK

    @property
    def excluded(self) -> Mapping[str, str]:
        """The streams that are not asked for, and why."""
        if self._allows_eye_images:
            return {}
        table = load_table()
        return {id: _EYE_IMAGES for id in table.streams if table.shows_eyes(id)}

    def allowed(self, rules: AppRules) -> AppRules:
        """Returns what is left of the rules for apps where anybody could be the app."""
        return rules if self._allows_control else rules.of_subscriptions()

    def listen_again(self, server: Server) -> None:
        """Listens everywhere as soon as the first device is paired."""
        with self._lock:
            if self._is_closed or not self._has_default or self._default != _EVERYWHERE:
                return
            if self.listener.getsockname()[:2] == _EVERYWHERE:
                return
            try:
                self.listener = server.listen_on(_EVERYWHERE)
            except ListenError as error:
                print(f"WARNING: {error.in_one_line()}", file=sys.stderr, flush=True)
                self.listener = server.listen_on(_LOOPBACK)
            self._announcement.close()
            self._announcement = self._announce()
            print(f"listening on {server.address}", flush=True)

    def close(self) -> None:
        """Headsets do not find it any more; a server that uses the listener may still stop."""
        with self._lock:
            self._is_closed = True
            self._announcement.close()

    def _announce(self) -> Announcement:
        host, port = self.listener.getsockname()[:2]
        if self.access.paired() is None:
            print(_INSECURE.format(text((host, port))), file=sys.stderr, flush=True)
        return Announcement(self.name, (host, port), self.access.fingerprint, _warn_unannounced)


def _warn_unannounced(reason: str) -> None:
    message = (
        f"WARNING: headsets do not find this receiver by name, give them its address: {reason}"
    )
    print(message, file=sys.stderr)

"""Where headsets come in: who may, on which address, and how they find it."""

import argparse
import sys
import threading
from collections.abc import Mapping
from pathlib import Path

from ..configuration.table import load_table
from ..errors import ListenError
from ..link.access import Access, Everybody, PairedOnly
from ..link.discovery import Announcement
from ..link.listener import listen
from ..link.server import Server
from ..security.folder import default_folder

PORT = 7755
_LOOPBACK, _EVERYWHERE = ("127.0.0.1", PORT), ("0.0.0.0", PORT)
_EYE_CAMERA = "com.magicleap.permission.EYE_CAMERA"
_EYE_IMAGES = "eye images are biometric: pair, or allow with --insecure-eye-images"
_INSECURE = (
    "WARNING: --insecure: no encryption, and everybody who can reach {} can send and be believed"
)


def add_keys(parser: argparse.ArgumentParser) -> None:
    """--keys."""
    parser.add_argument(
        "--keys",
        type=Path,
        default=default_folder(),
        metavar="FOLDER",
        help="with this receiver's key and the paired devices; default: ~/.config/ml2-sensors",
    )


def add_insecure(parser: argparse.ArgumentParser) -> None:
    """--insecure and --insecure-eye-images."""
    parser.add_argument(
        "--insecure",
        action="store_true",
        help="no TLS and no pairing: everybody on the network can read along and pretend to be a"
        " headset; the headset needs it too",
    )
    parser.add_argument(
        "--insecure-eye-images", action="store_true", help="with --insecure, eye images too"
    )


class Entrance:
    """Listens, and follows who is paired, until close().

    Args:
        options: has keys, insecure, insecure_eye_images, and listen, which is None for the default:
            this machine only, and all interfaces once a device is paired.

    Raises:
        KeysError, ListenError
    """

    def __init__(self, options: argparse.Namespace) -> None:
        self.access: Access = Everybody() if options.insecure else PairedOnly(options.keys)
        self._has_default = options.listen is None
        self.listener = listen(options.listen or self._default)
        self._allows_eye_images = not options.insecure or options.insecure_eye_images
        self._name = ""
        self._announcement: Announcement | None = None
        self._lock = threading.Lock()
        self._is_closed = False

    @property
    def _default(self) -> tuple[str, int]:
        return _EVERYWHERE if self.access.protection().paired else _LOOPBACK

    @property
    def withheld(self) -> Mapping[str, str]:
        """The streams that are not asked for, and why."""
        table = load_table()
        return {
            stream.id: _EYE_IMAGES
            for stream in table.streams.values()
            if _EYE_CAMERA in table.sections[stream.section].permissions
            and not self._allows_eye_images
        }

    def announce(self, name: str) -> None:
        """Headsets find it by this name from now on; says what is insecure."""
        self._name = name
        host, port = self.listener.getsockname()[:2]
        self._announcement = Announcement(
            name, (host, port), self.access.fingerprint, _warn_unannounced
        )
        if self.access.protection().paired is None:
            print(_INSECURE.format(f"{host}:{port}"), file=sys.stderr, flush=True)

    def follow(self, server: Server) -> None:
        """Who is paired has changed: with the first device, all interfaces are listened on."""
        with self._lock:
            if self._is_closed or not self._has_default or self._default != _EVERYWHERE:
                return
            if self.listener.getsockname()[:2] == _EVERYWHERE:
                return
            try:
                self.listener = server.listen_on(_EVERYWHERE)
            except ListenError as error:
                print(f"WARNING: {error}", file=sys.stderr, flush=True)
                self.listener = server.listen_on(_LOOPBACK)
            if self._announcement is not None:
                self._announcement.close()
            self.announce(self._name)
            print(f"listening on {server.address}", flush=True)

    def close(self) -> None:
        """Headsets do not find it any more; the listener is the server's to close."""
        with self._lock:
            self._is_closed = True
            if self._announcement is not None:
                self._announcement.close()


def _warn_unannounced(reason: str) -> None:
    message = (
        f"WARNING: headsets do not find this receiver by name, give them its address: {reason}"
    )
    print(message, file=sys.stderr)

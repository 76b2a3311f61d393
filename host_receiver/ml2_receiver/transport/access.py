"""Access control for the session port."""

import socket
import ssl
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from ..security.contexts import session_context
from ..security.identity import Identity
from ..security.paired_devices import PairedDevice, PairedDevices
from .tls_transport import TlsTransport
from .transport import PlainTransport, Transport


class Access(Protocol):
    """The access rules of the session port.

    Only paired() and `fingerprint` are thread-safe; other calls must not overlap.
    """

    @property
    def fingerprint(self) -> str | None:
        """The fingerprint of this receiver's certificate; None without TLS."""

    def refresh(self) -> bool:
        """Reads the paired devices again and returns True if they have changed.

        Raises:
            KeysError: the folder of keys is damaged. Only devices that are certainly still paired
                may connect.
        """

    def transport(self, accepted: socket.socket) -> Transport:
        """Returns the transport of an accepted connection.

        Raises:
            OSError: the peer has disconnected.
        """

    def allows(self, fingerprint: str | None) -> bool:
        """Returns True if the device with this certificate may have a session."""

    def paired(self) -> Mapping[str, str] | None:
        """Returns the names of the devices that may connect, by fingerprint.

        None without TLS, when any device may connect.
        """


class Everybody:
    """The access rules of `--insecure`: any device may connect."""

    fingerprint = None

    def refresh(self) -> bool:
        return False

    def transport(self, accepted: socket.socket) -> Transport:
        return PlainTransport(accepted)

    def allows(self, fingerprint: str | None) -> bool:
        return True

    def paired(self) -> None:
        return None


class PairedOnly:
    """The access rules with TLS: only devices that were paired at the last refresh() may connect.

    The receiver's own certificate may connect too, so `play` on this machine needs no pairing.

    Args:
        keys: the folder of keys; created if it is missing.

    Raises:
        KeysError: the folder cannot be used.
    """

    def __init__(self, keys: Path) -> None:
        self._identity = Identity.of(keys)
        self._store = PairedDevices(keys)
        self.fingerprint = self._identity.fingerprint
        self._fingerprints = self._store.fingerprints()
        self._use({it.fingerprint: it for it in self._store.load()})

    def refresh(self) -> bool:
        fingerprints = self._store.fingerprints()
        if fingerprints == self._fingerprints:
            return False
        self._fingerprints = fingerprints
        devices = {id: it for id, it in self._devices.items() if id in fingerprints}
        try:
            devices = {it.fingerprint: it for it in self._store.load()}
        finally:
            self._use(devices)
        return True

    def _use(self, devices: dict[str, PairedDevice]) -> None:
        self._devices = devices
        self._context: ssl.SSLContext = session_context(self._identity, devices.values())

    def transport(self, accepted: socket.socket) -> Transport:
        return TlsTransport(
            self._context.wrap_socket(accepted, server_side=True, do_handshake_on_connect=False)
        )

    def allows(self, fingerprint: str | None) -> bool:
        return fingerprint in self._devices or fingerprint == self.fingerprint

    def paired(self) -> Mapping[str, str]:
        return {id: it.name for id, it in self._devices.items()}

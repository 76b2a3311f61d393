"""Who may connect to the port for sessions."""

import socket
import ssl
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from ..security.contexts import session_context
from ..security.identity import Identity
from ..security.paired_devices import PairedDevice, PairedDevices
from .tls_transport import TlsTransport
from .transport import PlainTransport, Transport


@dataclass(frozen=True)
class Protection:
    """The protection of the port: `paired` has the names of the devices that may connect, by
    fingerprint.

    It is None without TLS, when everybody may.
    """

    paired: Mapping[str, str] | None


class Access(Protocol):
    """Calls must not overlap, but protection() and fingerprint are for any thread."""

    @property
    def fingerprint(self) -> str | None:
        """By which devices know this receiver; None without TLS."""

    def refresh(self) -> bool:
        """Whether somebody may come, or may not any more, for whom it was otherwise before.

        Raises:
            KeysError: the folder of keys is damaged; only who is surely paired may come.
        """

    def transport(self, accepted: socket.socket) -> Transport:
        """The connection as Server uses it.

        Raises:
            OSError: the peer has gone.
        """

    def allows(self, fingerprint: str | None) -> bool:
        """Whether who has shown this certificate may have a session."""

    def protection(self) -> Protection:
        """For people."""


class Everybody:
    """Access of `--insecure`."""

    fingerprint = None

    def refresh(self) -> bool:
        return False

    def transport(self, accepted: socket.socket) -> Transport:
        return PlainTransport(accepted)

    def allows(self, fingerprint: str | None) -> bool:
        return True

    def protection(self) -> Protection:
        return Protection(None)


class PairedOnly:
    """Access of devices that are paired, from the moment they are to the moment they are not.

    The receiver itself is one of them, so that `play` on this machine needs no pairing.

    Args:
        keys: the folder; made if need be.

    Raises:
        KeysError: it cannot be used.
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

    def protection(self) -> Protection:
        return Protection({id: it.name for id, it in self._devices.items()})

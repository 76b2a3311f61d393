"""A pairing that waits for a device, with the URIs that lead the device to it."""

import socket
from collections.abc import Callable
from pathlib import Path

from ..errors import PairingError
from ..generated.version import VERSION
from ..security.identity import Identity
from ..security.paired_devices import PairedDevice, PairedDevices
from ..transport.discovery import announced_hosts
from ..transport.listener import listen
from .listener import PairingListener
from .pairing import VALID_S, Pairing
from .uri import PairingUri


class OpenPairing:
    """Listens for one device, until close(). Not thread-safe.

    Args:
        address: the host and port to listen on; port 0 lets the system choose.
        keys: the folder of this receiver's key and the paired devices.
        name: the receiver's --name, or empty.
        sessions_port: where `run` listens.
        say: logs the address and the reason of each failed attempt, without secrets.

    Attributes:
        uris: a secret; one for each address of this machine.

    Raises:
        KeysError, ListenError
    """

    def __init__(
        self,
        address: tuple[str, int],
        keys: Path,
        name: str,
        sessions_port: int,
        say: Callable[[str], None],
    ) -> None:
        identity = Identity.of(keys)
        self._pairing = Pairing(identity.fingerprint)
        listening = listen(address)
        host, port = listening.getsockname()[:2]
        self.uris = [
            PairingUri(it, port, identity.fingerprint, self._pairing.token)
            for it in announced_hosts(host)
        ]
        self._listener = PairingListener(
            listening,
            identity,
            PairedDevices(keys),
            self._pairing,
            name=name or socket.gethostname(),
            software=f"ml2-receiver {VERSION}",
            sessions_port=sessions_port,
            say=say,
        )

    @property
    def left_s(self) -> float:
        """The time in s until the URIs expire."""
        return self._pairing.left_s

    def wait(self, timeout_s: float) -> PairedDevice | None:
        """Returns the device once it is paired, or None after the timeout.

        Raises:
            PairingError: no device can be paired any more.
            KeysError: the device cannot be stored.
        """
        if not self._listener.ended.wait(timeout_s):
            if self._pairing.is_guessed_at:
                raise PairingError(
                    "no headset was paired: too many wrong tokens arrived",
                    hint="Somebody on the network may be guessing. Pair on another network, or by"
                    " cable: `ml2-receiver headset start --pair -`.",
                )
            if not self._pairing.left_s and self._listener.device is None:
                raise PairingError(
                    f"no headset was paired within {VALID_S / 60:.0f} minutes",
                    hint="Run `ml2-receiver pair` again, and enter its code on the headset in that"
                    " time. The headset must reach this machine: check Wi-Fi and firewall.",
                )
            return None
        if self._listener.failure is not None:
            raise self._listener.failure
        return self._listener.device

    def close(self) -> None:
        """Stops listening."""
        self._listener.close()

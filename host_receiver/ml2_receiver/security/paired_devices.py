"""The paired devices, with a file for each."""

import json
import ssl
import sys
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from ..configuration.whole_file import read_file
from ..errors import KeysError, PairingError, file_hint
from .folder import REMOVE_HINT, locked, write
from .identity import fingerprint

_SUFFIX = ".json"
_MOST_BYTES = 64 * 1024


def _warn(text: str) -> None:
    print(f"WARNING: {text}", file=sys.stderr, flush=True)


@dataclass(frozen=True)
class PairedDevice:
    """A paired device; `certificate` is DER, `paired` is the time of pairing in ISO 8601."""

    name: str
    device_id: str
    paired: str
    certificate: bytes

    @property
    def fingerprint(self) -> str:
        return fingerprint(self.certificate)


class PairedDevices:
    """The paired devices in the folder `devices`, which any process may change at any time.

    Each file is named by its device's fingerprint, so the file names tell which devices are paired.
    A damaged file excludes only its own device.

    Methods raise KeysError if the folder cannot be used.

    Args:
        keys: the folder of keys, which contains `devices`.
        warn: called with a warning for each damaged file, which says what to do.
    """

    def __init__(self, keys: Path, warn: Callable[[str], None] = _warn) -> None:
        self._folder, self._warn = keys / "devices", warn

    def fingerprints(self) -> frozenset[str]:
        """Returns the fingerprints of the devices that are paired now."""
        try:
            files = list(self._folder.iterdir())
        except FileNotFoundError:
            return frozenset()
        except OSError as error:
            hint = file_hint(error, "choose another folder with --keys")
            raise KeysError(f"cannot use {self._folder}: {error.strerror}", hint=hint) from error
        return frozenset(file.stem for file in files if file.suffix == _SUFFIX)

    def load(self) -> list[PairedDevice]:
        """Returns the devices that are paired now, sorted by name."""
        devices = []
        for paired in sorted(self.fingerprints()):
            try:
                device = _read(self._file(paired))
            except KeysError as error:
                self._warn(error.in_one_line())
                continue
            if device is not None:
                devices.append(device)
        return sorted(devices, key=lambda it: it.name)

    def add(self, name: str, device_id: str, certificate: bytes) -> PairedDevice:
        """Pairs a device, or pairs it again; appends a number to its name if the name is taken."""
        with locked(self._folder):
            taken = {it.name for it in self.load() if it.certificate != certificate}
            paired = datetime.now(UTC).isoformat(timespec="seconds")
            device = PairedDevice(_free_name(name, taken), device_id, paired, certificate)
            document = {
                "name": device.name,
                "device_id": device_id,
                "paired": paired,
                "certificate": ssl.DER_cert_to_PEM_cert(certificate),
            }
            text = json.dumps(document, ensure_ascii=False, indent=2) + "\n"
            write(self._file(device.fingerprint), text.encode())
        return device

    def remove(self, name: str) -> PairedDevice:
        """Revokes the pairing of the device with this name or fingerprint.

        Raises:
            PairingError: there is no such device.
        """
        with locked(self._folder):
            devices = self.load()
            found = [it for it in devices if name in (it.name, it.fingerprint)]
            if not found:
                names = ", ".join(repr(it.name) for it in devices) or "none"
                raise PairingError(f"no paired device {name!r}; paired: {names}")
            self._file(found[0].fingerprint).unlink()
        return found[0]

    def _file(self, fingerprint: str) -> Path:
        return self._folder / f"{fingerprint}{_SUFFIX}"


def _read(file: Path) -> PairedDevice | None:
    try:
        document = json.loads(read_file(file, _MOST_BYTES))
        certificate = ssl.PEM_cert_to_DER_cert(document.pop("certificate"))
        device = PairedDevice(**document, certificate=certificate)
        if not all(isinstance(it, str) for it in document.values()):
            raise TypeError("every value must be a string")
        # A certificate that OpenSSL rejects would make the TLS context fail for all devices.
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_verify_locations(cadata=certificate)
    except FileNotFoundError:
        return None  # unpaired since the folder was listed
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise KeysError(f"{file} is not a paired device: {error}", hint=REMOVE_HINT) from error
    if device.fingerprint != file.stem:
        raise KeysError(f"{file} has another certificate than its name says", hint=REMOVE_HINT)
    return device


def _free_name(name: str, taken: set[str]) -> str:
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name} ({number})"
    return free

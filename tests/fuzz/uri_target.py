"""The pairing URI: one that is taken reads as it is written."""

from collections.abc import Iterator

from ml2_receiver.errors import PairingError
from ml2_receiver.pairing.uri import PairingUri
from vectors import PAIRING


def seeds() -> Iterator[bytes]:
    for host in ("192.168.1.5", "fd00::7", "lab-7.local"):
        yield str(PairingUri(host, 7756, PAIRING["fingerprint"], PAIRING["token"])).encode()


def read(data: bytes) -> None:
    text = data.decode(errors="replace")
    try:
        uri = PairingUri.parse(text)
    except PairingError:
        return
    assert PairingUri.parse(str(uri)) == uri

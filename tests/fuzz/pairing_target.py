"""PAIR: a device that is paired can connect, and does not keep the others out."""

import base64
import json
import ssl
from collections.abc import Iterator

from ml2_receiver.errors import ProtocolError
from ml2_receiver.pairing.pairing import Pairing
from ml2_receiver.wire.pairing_bodies import Pair
from vectors import HEADER_BYTES, PAIRING, vectors

_CERTIFICATE, _BODY = b"\x00", b"\x01"
_PAIR = {"name": "x", "device_id": "x"} | {it: PAIRING[it] for it in ("token", "signature")}


def seeds() -> Iterator[bytes]:
    """A certificate alone, or the body of PAIR."""
    yield _CERTIFICATE + base64.b64decode(PAIRING["certificate"])
    for _, data in (*vectors("wire", "Pair"), *vectors("malformed", "Pairing*")):
        yield _BODY + data[HEADER_BYTES:]


def read(data: bytes) -> None:
    pairing = Pairing(PAIRING["fingerprint"])
    pairing.token = PAIRING["token"]
    try:
        candidate = pairing.judge(Pair.parse(_body(data)), PAIRING["nonce"])
    except ProtocolError:
        return
    assert candidate.name.isprintable()
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_verify_locations(cadata=candidate.certificate)


def _body(data: bytes) -> bytes:
    if data[:1] != _CERTIFICATE:
        return data[1:]
    return json.dumps(_PAIR | {"certificate": base64.b64encode(data[1:]).decode()}).encode()

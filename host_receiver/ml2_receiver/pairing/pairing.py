"""One pairing without I/O: the challenge to a device, and the check of its answer."""

import base64
import binascii
import secrets
import ssl
import time
from collections.abc import Callable
from dataclasses import dataclass

from cryptography.exceptions import InvalidSignature, UnsupportedAlgorithm
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509 import InvalidVersion, load_der_x509_certificate

from ..errors import ErrorCode, ProtocolError
from ..wire.pairing_bodies import Pair

VALID_S = 300.0
WRONG_TOKENS = 5
_TOKEN_BYTES = 16
_NONCE_BYTES = 32


@dataclass(frozen=True)
class Candidate:
    """A device that has proved to have the token and its key; `certificate` is DER."""

    name: str
    device_id: str
    certificate: bytes


class Pairing:
    """A token for one device, which expires after 5 minutes or 5 wrong guesses.

    Calls must not overlap.

    Args:
        fingerprint: the fingerprint of the receiver's certificate.
        clock: returns monotonic time in s.
    """

    def __init__(self, fingerprint: str, clock: Callable[[], float] = time.monotonic) -> None:
        self.token = secrets.token_hex(_TOKEN_BYTES)
        self._fingerprint, self._clock = fingerprint, clock
        self._ends_s = clock() + VALID_S
        self._guesses_left = WRONG_TOKENS
        self._is_used = False

    @property
    def left_s(self) -> float:
        """The time in s until the token expires, whether it is used or not; 0 once expired."""
        return max(0.0, self._ends_s - self._clock()) if self._guesses_left else 0.0

    @property
    def is_guessed_at(self) -> bool:
        """True if wrong tokens have ended the pairing."""
        return not self._guesses_left

    @staticmethod
    def nonce() -> str:
        """Returns the nonce for the challenge of one connection."""
        return secrets.token_hex(_NONCE_BYTES)

    def judge(self, pair: Pair, nonce: str) -> Candidate:
        """Checks the answer to a challenge, uses the token up and returns the device.

        Raises:
            ProtocolError: `pairing`; the answer is wrong, or the token is used or expired. The
                message does not contain the token.
        """
        if self._is_used or not self.left_s:
            raise _refusal("the token is used or expired; run `ml2-receiver pair` again")
        if not secrets.compare_digest(pair.token.encode(), self.token.encode()):
            self._guesses_left -= 1
            raise _refusal(f"wrong token, {self._guesses_left} more allowed")
        certificate = _decoded(pair.certificate, "certificate")
        signed = signed_text(self._fingerprint, nonce, self.token)
        check_signature(certificate, _decoded(pair.signature, "signature"), signed)
        self._is_used = True
        return Candidate(pair.name, pair.device_id, certificate)


def signed_text(fingerprint: str, nonce: str, token: str) -> bytes:
    """Returns the text that a device signs."""
    return f"ml2s pair 1\n{fingerprint}\n{nonce}\n{token}".encode("ascii")


def check_signature(certificate: bytes, signature: bytes, signed: bytes) -> None:
    """Checks that the key of a DER certificate has signed `signed`.

    Raises:
        ProtocolError: `pairing`; it has not, or the certificate cannot be used.
    """
    try:
        parsed = load_der_x509_certificate(certificate)
        key = parsed.public_key()
        # A certificate that OpenSSL rejects would make the TLS context fail for all devices.
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_verify_locations(cadata=certificate)
    except (ValueError, UnsupportedAlgorithm, InvalidVersion, ssl.SSLError) as error:
        raise _refusal("the certificate is not valid X.509") from error
    if not isinstance(key, ec.EllipticCurvePublicKey) or not isinstance(key.curve, ec.SECP256R1):
        raise _refusal("expected a certificate with a key on the curve P-256")
    if parsed.public_bytes(Encoding.DER) != certificate:
        raise _refusal("the certificate is not DER")
    try:
        key.verify(signature, signed, ec.ECDSA(SHA256()))
    except InvalidSignature as error:
        raise _refusal("wrong signature") from error


def _decoded(text: str, key: str) -> bytes:
    try:
        return base64.b64decode(text.encode("ascii"), validate=True)
    except (binascii.Error, UnicodeEncodeError) as error:
        raise _refusal(f"the {key} is not base64") from error


def _refusal(message: str) -> ProtocolError:
    return ProtocolError(ErrorCode.PAIRING, message)

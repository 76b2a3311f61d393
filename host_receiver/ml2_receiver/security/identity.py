"""The identity of this receiver: a key, and a certificate that devices know by fingerprint."""

import hashlib
import ssl
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Self

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

from ..errors import KeysError
from .folder import REMOVE_HINT, locked, write

# A headset's date may be wrong. RFC 5280, 4.1.2.5, defines the second date as "no expiration".
_NOT_BEFORE = datetime(2000, 1, 1, tzinfo=UTC)
_NOT_AFTER = datetime(9999, 12, 31, 23, 59, 59, tzinfo=UTC)
_OTHERS = 0o077


def fingerprint(certificate: bytes) -> str:
    """Returns the SHA-256 of a DER certificate, as 64 lower-case hexadecimal digits."""
    return hashlib.sha256(certificate).hexdigest()


@dataclass(frozen=True)
class Identity:
    """A key and its certificate, as PEM files for ssl; `certificate` is the second one as DER."""

    key_file: Path
    certificate_file: Path
    certificate: bytes

    @classmethod
    def of(cls, folder: Path) -> Self:
        """Returns the identity in a folder, and creates it if there is none.

        Raises:
            KeysError: it can be neither read nor created, or other users can read the key.
        """
        key, certificate = folder / "receiver.key", folder / "receiver.pem"
        with locked(folder):
            if not certificate.exists():
                private = ec.generate_private_key(ec.SECP256R1())
                write(key, private_bytes(private))
                write(certificate, self_signed(private, "ml2-receiver").public_bytes(Encoding.PEM))
            for file in (key, certificate):
                if file.exists() and not file.is_file():  # reading a pipe would wait for ever
                    raise KeysError(f"{file}: expected a regular file", hint=REMOVE_HINT)
            if key.stat().st_mode & _OTHERS:
                raise KeysError(
                    f"others can read the key in {key}",
                    hint=f"Run `chmod 600 {key}`. If somebody has read it, remove it and pair all"
                    " headsets again.",
                )
            return cls(key, certificate, _der(certificate))

    @property
    def fingerprint(self) -> str:
        return fingerprint(self.certificate)


def _der(file: Path) -> bytes:
    try:
        return ssl.PEM_cert_to_DER_cert(file.read_text("ascii"))
    except ValueError as error:
        raise KeysError(f"{file} is not a certificate: {error}", hint=REMOVE_HINT) from error


def private_bytes(key: ec.EllipticCurvePrivateKey) -> bytes:
    """Returns a key as PKCS #8 in PEM."""
    return key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())


def self_signed(key: ec.EllipticCurvePrivateKey, name: str) -> x509.Certificate:
    """Returns a self-signed certificate; `name` is its common name."""
    subject = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)])
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(_NOT_BEFORE)
        .not_valid_after(_NOT_AFTER)
        .sign(key, SHA256())
    )

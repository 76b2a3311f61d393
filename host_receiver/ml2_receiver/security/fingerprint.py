"""The fingerprint of a certificate."""

import hashlib


def fingerprint(certificate: bytes) -> str:
    """Returns the SHA-256 of a DER certificate, as 64 lower-case hexadecimal digits."""
    return hashlib.sha256(certificate).hexdigest()

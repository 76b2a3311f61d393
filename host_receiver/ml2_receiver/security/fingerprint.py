"""How certificates are told apart."""

import hashlib


def fingerprint(certificate: bytes) -> str:
    """SHA-256 of a DER certificate, as 64 lower-case hexadecimal digits."""
    return hashlib.sha256(certificate).hexdigest()

"""The TLS contexts that PROTOCOL.md requires; they accept only TLS 1.3 and later."""

import ssl
from collections.abc import Iterable

from ..errors import KeysError
from .identity import Identity
from .paired_devices import PairedDevice

ALPN = "ml2s/1"


def session_context(identity: Identity, devices: Iterable[PairedDevice]) -> ssl.SSLContext:
    """Returns the context of the session port; a device has to show one of these certificates.

    OpenSSL also accepts a certificate that a device's key has signed, so compare the fingerprint
    after the handshake. Each context has its own ticket keys, so TLS sessions of another context
    cannot be resumed.

    Raises:
        KeysError: OpenSSL rejects the key.
    """
    context = _context(ssl.PROTOCOL_TLS_SERVER, identity)
    context.verify_mode = ssl.CERT_REQUIRED
    # Without this, OpenSSL finds only the first certificate of those with the same subject, and
    # all headsets have the same subject.
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    context.load_verify_locations(cadata=identity.certificate)
    for device in devices:
        context.load_verify_locations(cadata=device.certificate)
    return context


def pairing_context(identity: Identity) -> ssl.SSLContext:
    """Returns the context of the pairing port; only the receiver shows a certificate."""
    return _context(ssl.PROTOCOL_TLS_SERVER, identity)


def device_context(identity: Identity) -> ssl.SSLContext:
    """Returns the context of a device.

    It does not verify the receiver: compare the receiver's fingerprint before sending anything.
    """
    context = _context(ssl.PROTOCOL_TLS_CLIENT, identity)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    return context


def _context(protocol: int, identity: Identity) -> ssl.SSLContext:
    context = ssl.SSLContext(protocol)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    try:
        context.load_cert_chain(identity.certificate_file, identity.key_file)
    except OSError as error:
        reason = getattr(error, "reason", None) or error.strerror
        raise KeysError(
            f"{identity.key_file} is not the key of {identity.certificate_file}: {reason}",
            hint="Remove both files, and pair all headsets again: `ml2-receiver pair`.",
        ) from error
    context.set_alpn_protocols([ALPN])
    return context

"""TLS as PROTOCOL.md has it: 1.3 and nothing older."""

import ssl
from collections.abc import Iterable

from ..errors import KeysError
from .identity import Identity
from .paired_devices import PairedDevice

ALPN = "ml2s/1"


def session_context(identity: Identity, devices: Iterable[PairedDevice]) -> ssl.SSLContext:
    """Of the port for sessions: a device has to show one of these certificates.

    Also one that a device's key has signed gets through, so look it up after the handshake. Each
    context has ticket keys of its own: what another one let in cannot resume here.

    Raises:
        KeysError: OpenSSL does not take the key.
    """
    context = _context(ssl.PROTOCOL_TLS_SERVER, identity)
    context.verify_mode = ssl.CERT_REQUIRED
    # Else of certificates with the same subject, as headsets have, only the first is found.
    context.verify_flags |= ssl.VERIFY_X509_PARTIAL_CHAIN
    context.load_verify_locations(cadata=identity.certificate)
    for device in devices:
        context.load_verify_locations(cadata=device.certificate)
    return context


def pairing_context(identity: Identity) -> ssl.SSLContext:
    """Of the port for pairing: only the receiver shows who it is."""
    return _context(ssl.PROTOCOL_TLS_SERVER, identity)


def device_context(identity: Identity) -> ssl.SSLContext:
    """Of a device; it has to compare the receiver's fingerprint before it sends anything."""
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

"""Devices with certificates, made with cryptography and ssl and no code of the product."""

import ssl
import threading
from contextlib import suppress
from datetime import UTC, datetime
from ipaddress import ip_address
from pathlib import Path
from typing import Self

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256, Hash
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

from ml2_receiver.wire.kinds import Kind
from mock_device import MockDevice
from repeated import begin

_PERIOD_S = 0.02


class Certificate:
    """A key and its certificate, self-signed or by `issuer`, in files of a folder.

    With `is_server` it is one for programs on 127.0.0.1.
    """

    def __init__(
        self,
        folder: Path,
        name: str,
        issuer: "Certificate | None" = None,
        *,
        is_authority: bool = False,
        is_server: bool = False,
    ) -> None:
        self.key = ec.generate_private_key(ec.SECP256R1())
        subject: x509.Name = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)])
        self.subject = subject
        builder = (
            x509.CertificateBuilder()
            .subject_name(subject)
            .issuer_name(issuer.subject if issuer else subject)
            .public_key(self.key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(datetime(2000, 1, 1, tzinfo=UTC))
            .not_valid_after(datetime(9999, 12, 31, 23, 59, 59, tzinfo=UTC))
            .add_extension(x509.BasicConstraints(is_authority, None), critical=True)
        )
        if is_server:
            host = x509.IPAddress(ip_address("127.0.0.1"))
            builder = builder.add_extension(x509.SubjectAlternativeName([host]), critical=False)
        certificate = builder.sign(issuer.key if issuer else self.key, SHA256())
        self.der = certificate.public_bytes(Encoding.DER)
        chain = certificate.public_bytes(Encoding.PEM)
        if issuer is not None:
            chain += ssl.DER_cert_to_PEM_cert(issuer.der).encode()
        folder.mkdir(parents=True, exist_ok=True)
        self.key_file, self.chain_file = folder / "key.pem", folder / "chain.pem"
        self.chain_file.write_bytes(chain)
        self.key_file.write_bytes(
            self.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
        )

    @property
    def fingerprint(self) -> str:
        digest = Hash(SHA256())
        digest.update(self.der)
        return digest.finalize().hex()

    def context(self) -> ssl.SSLContext:
        """Returns the context of a device that shows this certificate."""
        context = anonymous_context()
        context.load_cert_chain(self.chain_file, self.key_file)
        return context


def anonymous_context() -> ssl.SSLContext:
    """Returns the context of a device that shows no certificate and trusts everybody."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_NONE
    context.set_alpn_protocols(["ml2s/1"])
    return context


class StreamingDevice:
    """A session that sends a message of `topic` fifty times per second until it is left."""

    def __init__(self, address: str, tls: ssl.SSLContext | None, topic: str) -> None:
        self.device = MockDevice(address, tls=tls)
        self._topic = topic
        self._leaving = threading.Event()
        self._sender = threading.Thread(target=self._send, daemon=True)

    def __enter__(self) -> Self:
        begin(self.device)
        self._sender.start()
        return self

    def _send(self) -> None:
        with suppress(OSError):  # the receiver has ended the session
            while not self._leaving.wait(_PERIOD_S):
                self.device.publish(self._topic)
                self.device.wires["control"].send(Kind.PING)

    def __exit__(self, *_: object) -> None:
        self._leaving.set()
        self._sender.join()
        self.device.disconnect()

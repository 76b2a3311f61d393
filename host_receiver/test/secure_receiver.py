"""A receiver that takes paired devices, and devices with certificates, paired or not."""

import re
import socket
import ssl
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from fake_sink import FakeGraph, FakeSink
from ml2_receiver.configuration.app_rules import AppRules, NameRules
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import Limits, ReceiverSettings
from ml2_receiver.transport.access import Access, Everybody, PairedOnly
from ml2_receiver.transport.listener import listen
from scene import PATIENT, REQUEST
from tls_device import Certificate, StreamingDevice
from waiting import LIMIT_S

BATTERY = "battery"
UNPAIRED_ADDRESS = "127.0.0.2"
LIMITS = replace(PATIENT, linger_s=0.3, failed_attempts=10_000)
QUICK = replace(LIMITS, handshake_s=1.0)
# Tokens, tickets and sessions.
_ALL = AppRules(subscribe=NameRules(("/**",)))
_SECRET = re.compile(r"\b[0-9a-f]{32}\b")


class SecureReceiver:
    """Keys are in `folder`."""

    def __init__(self, folder: Path, limits: Limits) -> None:
        self.folder, self.sink, self.limits = folder, FakeSink(), limits
        self.graph = FakeGraph()
        self.devices = PairedDevices(folder / "keys")
        self.servers: list[Server] = []
        self.address = self.serve(PairedOnly(folder / "keys"))
        self.server = self.servers[0]

    def serve(self, access: Access, listening: str = "127.0.0.1") -> tuple[str, int]:
        server = Server(
            listen((listening, 0)),
            access,
            self.sink,
            REQUEST,
            ReceiverSettings(
                "host", "test", limits=self.limits, app=lambda: _ALL, graph=self.graph
            ),
        )
        server.start()
        self.servers.append(server)
        host, _, port = server.address.rpartition(":")
        return host, int(port)

    def insecure(self) -> tuple[str, int]:
        """The address of one more receiver, without TLS."""
        return self.serve(Everybody())

    def stop(self) -> None:
        """Fails if the log had a secret."""
        for server in self.servers:
            server.stop()
        assert not [event for event in self.sink.events if _SECRET.search(event)]

    def certificate(
        self, name: str, issuer: Certificate | None = None, *, is_authority: bool = False
    ) -> Certificate:
        return Certificate(self.folder / name, name, issuer, is_authority=is_authority)

    def paired(self, name: str) -> Certificate:
        certificate = self.certificate(name)
        self.devices.add(name, name, certificate.der)
        return certificate

    def streaming(self) -> StreamingDevice:
        return StreamingDevice(self.server.address, self.paired("headset").context(), BATTERY)

    def connect(self) -> socket.socket:
        """An unpaired peer's bare connection."""
        return socket.create_connection(self.address, LIMIT_S, (UNPAIRED_ADDRESS, 0))

    def received(self) -> int:
        return len(self.sink.payloads[BATTERY])

    def await_more(self, count: int = 5) -> None:
        self.sink.await_payloads(BATTERY, self.received() + count)


# Opens a receiver with these limits.
type OpenLab = Callable[[Limits], SecureReceiver]


def refused(connect: Callable[[], ssl.SSLSocket]) -> str:
    """Returns the reason that a refused peer reads: TLS 1.3 sends its alert with the first read."""
    try:
        with connect() as tls:
            assert tls.recv(1) == b""
    except (ssl.SSLError, ConnectionError) as error:
        return str(error).upper()
    return ""

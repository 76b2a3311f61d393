"""vectors/pairing, and the port for pairing against its part of vectors/malformed."""

import base64
import socket
import ssl
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from case_files import Vector, load, named
from ml2_receiver.errors import ProtocolError
from ml2_receiver.pairing import listener as pairing_listener
from ml2_receiver.pairing.listener import PairingListener
from ml2_receiver.pairing.pairing import Pairing, check_signature, signed_text
from ml2_receiver.security.identity import Identity
from ml2_receiver.security.paired_devices import PairedDevices
from ml2_receiver.transport.listener import listen
from scripted_device import Peer
from waiting import LIMIT_S

SIGNATURES = load("pairing")
CASES = named("malformed", "Pairing*")


@pytest.mark.parametrize("name", SIGNATURES)
def test_good_signatures_are_taken_and_others_refused(name: str) -> None:
    case = SIGNATURES[name].case
    signed = signed_text(case["fingerprint"], case["nonce"], case["token"])
    certificate = base64.b64decode(case["certificate"])
    signature = base64.b64decode(case["signature"])
    if case["is_valid"]:
        assert signed.decode() == case["signed"]
        check_signature(certificate, signature, signed)
    else:
        with pytest.raises(ProtocolError, match=r"pairing: (wrong signature|the certificate)"):
            check_signature(certificate, signature, signed)


def test_the_exchange_of_the_wire_vectors_is_the_valid_one() -> None:
    good = SIGNATURES["Signature"].case
    sent = {"PairChallenge": ["nonce"], "Pair": ["token", "certificate", "signature"]}
    for name, keys in sent.items():
        (frame,) = load("wire")[name].case["frames"]
        assert [frame["json"][key] for key in keys] == [good[key] for key in keys]


class TlsPeer(Peer):
    """A connection to the port for pairing."""

    def __init__(self, address: tuple[str, int]) -> None:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
        context.set_alpn_protocols(["ml2s/1"])
        self._socket = context.wrap_socket(socket.create_connection(address, LIMIT_S))
        self._input = self._socket.makefile("rb")


class Port:
    """The pairing port."""

    def __init__(self, keys: Path) -> None:
        identity = Identity.of(keys)
        listener = listen(("127.0.0.1", 0))
        self.address: tuple[str, int] = listener.getsockname()[:2]
        self.devices = PairedDevices(keys)
        self.said: list[str] = []
        self._told = threading.Condition()
        self.listener = PairingListener(
            listener,
            identity,
            self.devices,
            Pairing(identity.fingerprint),
            name="test",
            software="test",
            sessions_port=7755,
            say=self._say,
        )

    def _say(self, text: str) -> None:
        with self._told:
            self.said.append(text)
            self._told.notify_all()

    def await_said(self, text: str) -> None:
        with self._told:
            assert self._told.wait_for(lambda: any(text in it for it in self.said), LIMIT_S)


@pytest.fixture
def port(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Port]:
    monkeypatch.setattr(pairing_listener, "_EXCHANGE_S", 1.0)
    port = Port(tmp_path)
    yield port
    port.listener.close()


@pytest.mark.parametrize("vector", CASES, ids=lambda vector: vector.name)
def test_faulty_devices_are_told_and_nobody_is_paired(vector: Vector, port: Port) -> None:
    peer = TlsPeer(port.address)
    peer.expect("PAIR_CHALLENGE")
    peer.send(vector.data)
    error = peer.expect("ERROR").json
    assert (error["code"], error["fatal"]) == (vector.case["expect"]["error"], True), error
    assert peer.read().name is None
    peer.close()
    port.await_said(error["message"])
    assert port.devices.load() == []

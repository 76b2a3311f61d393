import base64
import json
from pathlib import Path

import pytest
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.hashes import SHA256

from ml2_receiver.errors import ErrorCode, PairingError, ProtocolError
from ml2_receiver.pairing.pairing import Pairing
from ml2_receiver.pairing.uri import PairingUri
from ml2_receiver.wire.pairing_bodies import Pair
from tls_device import Certificate

FINGERPRINT = "ab" * 32
NONCE = "cd" * 32


class Clock:
    now_s = 50.0

    def __call__(self) -> float:
        return self.now_s


class Scene:
    def __init__(self, folder: Path) -> None:
        self.clock = Clock()
        self.pairing = Pairing(FINGERPRINT, self.clock)
        self.certificate = Certificate(folder, "device")

    def pair(self, **changes: str) -> Pair:
        """A good answer to NONCE, but for `changes`, which are of what is signed, too."""
        parts = {"fingerprint": FINGERPRINT, "nonce": NONCE, "token": self.pairing.token} | changes
        signed = "ml2s pair 1\n{fingerprint}\n{nonce}\n{token}".format(**parts).encode()
        signature = self.certificate.key.sign(signed, ec.ECDSA(SHA256()))
        fields = {
            "token": parts["token"],
            "name": "ML2",
            "device_id": "id",
            "certificate": base64.b64encode(self.certificate.der).decode(),
            "signature": base64.b64encode(signature).decode(),
        }
        return Pair(**{key: changes.get(key, value) for key, value in fields.items()})

    def refusal(self, pair: Pair) -> str:
        with pytest.raises(ProtocolError) as raised:
            self.pairing.judge(pair, NONCE)
        assert raised.value.code == ErrorCode.PAIRING
        assert self.pairing.token not in raised.value.message
        return raised.value.message


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    return Scene(tmp_path)


def test_token_and_signature_make_a_candidate(scene: Scene) -> None:
    candidate = scene.pairing.judge(scene.pair(), NONCE)
    assert (candidate.name, candidate.device_id) == ("ML2", "id")
    assert candidate.certificate == scene.certificate.der


def test_tokens_are_random(scene: Scene) -> None:
    tokens = {Pairing(FINGERPRINT).token for _ in range(100)}
    assert len(tokens) == 100
    assert {len(token) for token in tokens} == {32}


def test_a_token_is_for_one_device(scene: Scene) -> None:
    pair = scene.pair()
    scene.pairing.judge(pair, NONCE)
    assert scene.pairing.left_s == 300, "to remember the device takes time, too"
    assert "used or expired" in scene.refusal(pair)


def test_a_token_is_for_five_minutes(scene: Scene) -> None:
    scene.clock.now_s += 299
    assert scene.pairing.left_s == 1
    scene.clock.now_s += 1
    assert "used or expired" in scene.refusal(scene.pair())


def test_five_wrong_tokens_end_it(scene: Scene) -> None:
    for left in (4, 3, 2, 1, 0):
        assert scene.refusal(scene.pair(token="0" * 32)) == f"wrong token, {left} more allowed"
    assert scene.pairing.is_guessed_at
    assert "used or expired" in scene.refusal(scene.pair())


@pytest.mark.parametrize("changed", [{"fingerprint": "00" * 32}, {"nonce": "00" * 32}])
def test_a_signature_of_another_pairing_is_refused(scene: Scene, changed: dict[str, str]) -> None:
    assert scene.refusal(scene.pair(**changed)) == "wrong signature"


def test_a_signature_of_another_key_is_refused(scene: Scene, tmp_path: Path) -> None:
    own = scene.pair()
    scene.certificate = Certificate(tmp_path / "other", "other")
    assert scene.refusal(scene.pair(certificate=own.certificate)) == "wrong signature"


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"certificate": "ä"}, "the certificate is not base64"),
        ({"certificate": "AAAA"}, "the certificate is not valid X.509"),
        ({"signature": "?"}, "the signature is not base64"),
        ({"signature": "AAAA"}, "wrong signature"),
        ({"signature": ""}, "wrong signature"),
    ],
)
def test_what_is_no_certificate_or_signature_is_refused(
    scene: Scene, changed: dict[str, str], reason: str
) -> None:
    assert scene.refusal(scene.pair(**changed)) == reason


def test_bytes_after_a_certificate_are_refused(scene: Scene) -> None:
    longer = base64.b64encode(scene.certificate.der + b"\0").decode()
    assert "the certificate is not" in scene.refusal(scene.pair(certificate=longer))


@pytest.mark.parametrize(
    ("found", "by"),
    [
        (bytes.fromhex("06082a8648ce3d030107"), bytes.fromhex("06082a8648ce3d030150")),
        (bytes.fromhex("a003020102"), bytes.fromhex("a003020105")),
        (b"\x0c\x06device", b"\x0c\x06\xffevice"),
    ],
    ids=["unknown curve", "version 6", "name that is not UTF-8"],
)
def test_certificates_that_some_library_does_not_take_are_refused(
    scene: Scene, found: bytes, by: bytes
) -> None:
    assert found in scene.certificate.der
    changed = base64.b64encode(scene.certificate.der.replace(found, by)).decode()
    assert scene.refusal(scene.pair(certificate=changed)) == "the certificate is not valid X.509"


@pytest.mark.parametrize("name", ["", "x" * 65, "a\x1b[2J", "a\nb"])
def test_a_name_that_would_disturb_a_terminal_is_malformed(scene: Scene, name: str) -> None:
    body = scene.pair().to_bytes().replace(b'"ML2"', json.dumps(name).encode())
    with pytest.raises(ProtocolError, match="malformed"):
        Pair.parse(body)


@pytest.mark.parametrize("host", ["192.168.1.5", "::1"])
def test_a_uri_is_read_as_it_was_shown(host: str) -> None:
    uri = PairingUri(host, 40123, FINGERPRINT, "0" * 32)
    assert PairingUri.parse(str(uri)) == uri
    shown = f"[{host}]" if ":" in host else host
    assert str(uri) == f"ml2s://{shown}:40123?fp={FINGERPRINT}&token={'0' * 32}"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "ml2s://",
        f"https://a:1?fp={FINGERPRINT}&token={'0' * 32}",
        f"ml2s://a?fp={FINGERPRINT}&token={'0' * 32}",
        f"ml2s://a:70000?fp={FINGERPRINT}&token={'0' * 32}",
        f"ml2s://a:1?fp={FINGERPRINT[1:]}&token={'0' * 32}",
        f"ml2s://a:1?fp={FINGERPRINT}&token={'g' * 32}",
        f"ml2s://a:1?fp={FINGERPRINT}",
        "ml2s://[a:1",
    ],
)
def test_what_is_no_uri_is_refused_without_being_repeated(text: str) -> None:
    with pytest.raises(PairingError, match=r"expected ml2s://HOST:PORT") as raised:
        PairingUri.parse(text)
    assert "0000" not in str(raised.value)

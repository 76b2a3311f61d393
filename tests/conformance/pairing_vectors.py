"""The signatures of pairing, valid and invalid: vectors/pairing."""

import base64
from typing import Any

from bodies import PAIR, PAIR_CHALLENGE, RECEIVER_FINGERPRINT
from case_files import text

_OTHER_CERTIFICATE = (
    "MIIBNTCB3KADAgECAhRa//JWE4G1sg61eqSSAJX10hSsvDAKBggqhkjOPQQDAjAaMRgwFgYDVQQDDA9Bbm90aGVy"
    "IGhlYWRzZXQwIBcNMDAwMTAxMDAwMDAwWhgPOTk5OTEyMzEyMzU5NTlaMBoxGDAWBgNVBAMMD0Fub3RoZXIgaGVh"
    "ZHNldDBZMBMGByqGSM49AgEGCCqGSM49AwEHA0IABJPW/1gl54vYNTTTbnHpmuhQDQ386Bdmu4Vja4TVYo5hx77J"
    "HbigoDt/8M1tDZ7PiOSmBIaj3huW/9W/hQk03+0wCgYIKoZIzj0EAwIDSAAwRQIgE9j2skKc3yYUYODORjLzAbH3"
    "QsKVUaD4fxprh1yN4ZICIQDCHFJGBLr3+x5zBH+QE90gL2vkW+7u0I6gHjhgswEXpQ=="
)


def _changed(found: str, by: str) -> str:
    """The good certificate with other bytes, in hexadecimal; its key has signed the exchange."""
    certificate = base64.b64decode(PAIR["certificate"])
    assert bytes.fromhex(found) in certificate
    return base64.b64encode(certificate.replace(bytes.fromhex(found), bytes.fromhex(by))).decode()


def files() -> dict[str, bytes]:
    good: dict[str, Any] = {
        "fingerprint": RECEIVER_FINGERPRINT,
        "nonce": PAIR_CHALLENGE["nonce"],
        "token": PAIR["token"],
        "certificate": PAIR["certificate"],
        "signature": PAIR["signature"],
    }
    signed = "ml2s pair 1\n{fingerprint}\n{nonce}\n{token}".format(**good)
    cases: dict[str, dict[str, Any]] = {
        "Signature": good | {"signed": signed, "why": "By the certificate's key, over `signed`."},
        "OtherReceiver": good | {"fingerprint": "6e" * 32, "why": "Signed for another receiver."},
        "OtherNonce": good | {"nonce": "00" * 32, "why": "Heard on another connection."},
        "OtherToken": good | {"token": "00" * 16, "why": "Signed for another token."},
        "OtherKey": good | {"certificate": _OTHER_CERTIFICATE, "why": "Another key has signed."},
        "NoSignature": good | {"signature": "", "why": "Nothing is not a signature."},
        "UnknownCurve": good
        | {
            "certificate": _changed("2a8648ce3d030107", "2a8648ce3d030150"),
            "why": "Not the curve P-256, and none that there is.",
        },
        "UnknownVersion": good
        | {
            "certificate": _changed("a003020102", "a003020105"),
            "why": "X.509 has no version 6.",
        },
        "NameNotUtf8": good
        | {
            "certificate": _changed(b"headset".hex(), b"\xffeadset".hex()),
            "why": "Some libraries take such a certificate, and others fail over it later.",
        },
        "NotDer": good | {"signature": "MAA=", "why": "An empty sequence is not a signature."},
    }
    signed_cases = {name: case | {"is_valid": name == "Signature"} for name, case in cases.items()}
    return {"signatures.json": text(signed_cases, "is_valid why")}

"""The input of the pairing port from a broken, older or malicious device."""

from bodies import HELLO, PAIR
from frame_bytes import BOUNDS, KIB, KINDS, frame, header, json_frame
from malformed_case import Case, error, key_cases, over_bound
from malformed_json import json_cases


def cases() -> dict[str, Case]:
    def case(code: str, sent: bytes, why: str) -> Case:
        return Case("challenged", "pairing", sent, error(code), why)

    def pair(code: str, why: str, **changes: object) -> Case:
        return case(code, json_frame("PAIR", PAIR | changes), why)

    large = header(KINDS["PAIR"], BOUNDS["PAIR"] + 1)
    broken = json_cases("PAIR", "challenged", "pairing", PAIR, "name")
    return (
        {name: it for name, it in broken.items() if len(it.sent) <= BOUNDS["PAIR"]}
        | key_cases("PAIR", "challenged", "pairing", PAIR)
        | over_bound("PAIR", large, "challenged", "pairing", BOUNDS["PAIR"])
        | {
            "LengthMaximum": case("too_large", header(KINDS["PAIR"], 2**32 - 1), "4 GiB."),
            "NewerVersion": case("version", header(KINDS["PAIR"], 0, version=2), "Version 2."),
            "OtherMagic": case("malformed", header(61, 0, magic=b"2M"), "Not this protocol."),
            "Hello": case("unexpected", json_frame("HELLO", HELLO), "Sessions are elsewhere."),
            "Data": case("unexpected", frame("DATA", bytes(8)), "Nothing is streamed here."),
            "UnknownKind": case("unexpected", header(99, 3) + b"abc", "Only PAIR is expected."),
            "PairedFromDevice": case(
                "unexpected", json_frame("PAIRED", {"name": "x", "port": 1}), "The receiver's."
            ),
            "Silent": case("timeout", b"", "Nothing is sent."),
            "SilentInFrame": case(
                "timeout", header(KINDS["PAIR"], 16 * KIB) + b"{", "The rest does not come."
            ),
            "OtherToken": pair("pairing", "Not the token that is shown.", token="0" * 32),
            "LongToken": pair("pairing", "Not the token that is shown.", token="0" * 9000),
            "NonAsciiToken": pair("pairing", "Not the token that is shown.", token="é" * 32),
            "NameEmpty": pair("malformed", "People have to know it by something.", name=""),
            "NameTooLong": pair("malformed", "65 characters.", name="x" * 65),
            "NameWithEscape": pair("malformed", "Would move a terminal's cursor.", name="\x1b[2J"),
            "NameWithNewline": pair("malformed", "Would forge a line of a log.", name="a\nb"),
            "DeviceIdTooLong": pair("malformed", "129 characters.", device_id="x" * 129),
        }
    )

"""No malformed case is missing that the tables of PROTOCOL.md ask for."""

import json
import struct
from typing import Any

import pytest

from bodies import REQUEST, VALID
from case_files import load
from frame_bytes import BOUNDS, KINDS, pascal
from ml2_receiver.wire.kinds import Body, Kind, LaneKind, Side

CASES = load("malformed")
PEERS = {"Receiver": Side.DEVICE, "Device": Side.RECEIVER}
# Kinds whose first body on a connection has every fault of JSON.
FIRST = {"Receiver": "HELLO", "Device": "WELCOME", "Pairing": "PAIR"}
FAULTS_OF_JSON = (
    *("Empty", "NotJson", "Array", "Null", "Unfinished", "TextAfter", "ZeroAfter"),
    *("ByteOrderMark", "Utf16", "InvalidUtf8", "OverlongUtf8", "EncodedSurrogate"),
    *("LoneSurrogate", "ControlCharacter", "SingleQuotes", "Comment", "TrailingComma"),
    *("NaN", "Infinity", "SeventeenDeep"),
)
# These faults make a body longer than a PAIR may be.
LONG_FAULTS = ("VeryDeep", "DeepOpenOnly")
# Objects in bodies whose keys are fixed.
NESTED = {"HELLO": ("capabilities",), "STATUS": ("clock",), "WELCOME": ("timeouts", "limits")}
HEADER_BYTES = 32


def received(side: str) -> list[Kind]:
    """The kinds that the peer of a side may send."""
    if side == "Pairing":
        return [Kind.PAIR]
    return [it for it in Kind if it.sender & PEERS[side] and it.lanes & ~LaneKind.PAIRING]


def keys(kind: Kind) -> list[tuple[str, ...]]:
    """The places of all keys of a body of JSON. An ERROR is never answered."""
    if kind.body is not Body.JSON or kind is Kind.ERROR:
        return []
    inner = [(it, key) for it in NESTED.get(kind.name, ()) for key in VALID[kind.name][it]]
    return [*((key,) for key in VALID[kind.name]), *inner]


KEYS = [
    (f"{side}{pascal(kind.name)}{{}}{pascal('.'.join(place))}", kind, place)
    for side in FIRST
    for kind in received(side)
    for place in keys(kind)
]


def body(name: str) -> Any:
    """The JSON of the only frame of a case."""
    return json.loads(CASES[name].data[HEADER_BYTES:].replace(REQUEST.encode(), b"1"))


def value(body: Any, place: tuple[str, ...]) -> Any:
    for key in place:
        body = body[key]
    return 1 if body == REQUEST else body


@pytest.mark.parametrize(("name", "kind", "place"), KEYS, ids=str)
def test_each_key_is_once_missing_and_once_of_another_type(
    name: str, kind: Kind, place: tuple[str, ...]
) -> None:
    *outer, key = place
    assert key not in value(body(name.format("Without")), tuple(outer))
    wrong = value(body(name.format("Mistyped")), place)
    assert type(wrong) is not type(value(VALID[kind.name], place))


@pytest.mark.parametrize("side", FIRST)
def test_each_kind_is_once_longer_than_its_bound(side: str) -> None:
    for kind in received(side):
        _, case, data = CASES[f"{side}{pascal(kind.name)}TooLarge"]
        number, length = struct.unpack_from("<3xB8xI", data)
        assert (number, length) == (KINDS[kind.name], BOUNDS[kind.name] + 1)
        assert case["expect"] == {"error": "too_large"}


@pytest.mark.parametrize("side", PEERS)
def test_each_kind_comes_once_from_the_wrong_side(side: str) -> None:
    (other,) = PEERS.keys() - {side}
    wrong = [it for it in received(other) if it not in received(side)]
    for kind in wrong:
        assert CASES[f"{side}{pascal(kind.name)}From{other}"].data[3] == KINDS[kind.name]


@pytest.mark.parametrize("side", PEERS)
def test_unknown_kinds_come_on_each_lane(side: str) -> None:
    lanes = ["control", "time", "sensors", "world_left"]
    lanes += ["link_test"] if side == "Receiver" else []  # a device reads nothing there
    lanes += ["ros", "bulk_1"]
    for lane in lanes:
        case = CASES[f"{side}UnknownKindsOn{pascal(lane)}"].case
        assert (case["lane"], case["expect"]) == (lane, {"skipped": 3})


@pytest.mark.parametrize("side", PEERS)
def test_kinds_of_openings_are_unknown_in_a_session_without_them(side: str) -> None:
    kinds = [int(kind) for kind in Kind if kind.is_of_openings]
    for lane in ("control", "time", "sensors", "world_left"):
        _, case, _ = CASES[f"{side}OpeningsUnknownOn{pascal(lane)}"]
        assert [part["frame"] for part in case["sent"]] == kinds
        assert (case["given"], case["lane"]) == ("streaming", lane)
        assert (case["expect"], "ros" in case) == ({"skipped": len(kinds)}, False)


@pytest.mark.parametrize("side", PEERS)
def test_each_kind_comes_once_on_a_wrong_lane_for_a_wrong_and_for_an_ended_opening(
    side: str,
) -> None:
    for kind in received(side):
        if kind.is_of_openings and not kind.lanes & LaneKind.CONTROL:
            codes = {
                name: CASES[f"{side}{pascal(kind.name)}{name}"].case["expect"]
                for name in ("OnControl", "NeverOpened", "OfRefused")
            }
            wrong = {"error": "unexpected"}
            assert list(codes.values()) == [wrong, wrong, {"late": 1}], (kind, codes)


@pytest.mark.parametrize(("side", "kind"), FIRST.items())
def test_the_first_body_has_each_fault_of_json(side: str, kind: str) -> None:
    for fault in (*FAULTS_OF_JSON, *(LONG_FAULTS if side != "Pairing" else ())):
        assert f"{side}{pascal(kind)}{fault}" in CASES, fault

"""DATA a receiver gets that is not what was announced, and frames that end too early."""

import struct

from bodies import CHANNELS, HELLO, JOIN, STRING_PAYLOAD
from frame_bytes import BOUNDS, KINDS, frame, header, json_frame
from malformed_case import Case, body_frame, error
from malformed_receiver import data


def data_frames() -> dict[str, Case]:
    battery, image = CHANNELS[0]["id"], CHANNELS[1]["id"]

    def case(lane: str, code: str, why: str, sent: bytes) -> Case:
        return Case("streaming", lane, sent, error(code), why)

    last = 2**31
    return {
        "DataUnknownChannel": case("sensors", "channel", "Never announced.", data(65535)),
        "DataChannelZero": case("sensors", "channel", "No channel has the number 0.", data(0)),
        "DataImageOnSensors": case("sensors", "channel", "Announced on world_left.", data(image)),
        "DataSensorOnImageLane": case(
            "world_left", "channel", "Announced on sensors.", data(battery)
        ),
        "DataEmpty": case("sensors", "malformed", "No encapsulation.", data(battery, 0, b"")),
        "DataThreeBytes": case(
            "sensors", "malformed", "No encapsulation.", data(battery, 0, b"\0\1\0")
        ),
        "DataBigEndian": case(
            "sensors",
            "malformed",
            "Big-endian CDR.",
            data(battery, 0, bytes(4) + STRING_PAYLOAD[4:]),
        ),
        "DataCdr2": case(
            "sensors", "malformed", "CDR2.", data(battery, 0, b"\0\7\0\0" + STRING_PAYLOAD[4:])
        ),
        "DataSameSequence": case(
            "sensors", "malformed", "A number is given once.", data(battery, 5) * 2
        ),
        "DataOlderSequence": case(
            "sensors", "malformed", "Numbers grow.", data(battery, 5) + data(battery, 4)
        ),
        "DataHalfwayRound": case(
            "sensors",
            "malformed",
            "2^31 ahead is as well 2^31 behind.",
            data(battery, 5) + data(battery, 5 + last),
        ),
    }


def cuts() -> dict[str, Case]:
    """The sender's output ends after each number of bytes short of the whole."""

    def cut(given: str, lane: str, sent: bytes, what: str) -> Case:
        why = f"{what} ends inside the frame."
        return Case(given, lane, sent, {"closed": True}, why, cut=True)

    short_hello = {key: HELLO[key] for key in ("versions", "device_id", "name")}
    time = struct.pack("<q", 5_000_000_001)
    return {
        "HelloCut": cut("connected", "control", json_frame("HELLO", short_hello), "The connection"),
        "JoinCut": cut("connected", "sensors", body_frame("JOIN", JOIN), "The connection"),
        "ByeCut": cut("streaming", "control", json_frame("BYE", {"reason": "x"}), "Control"),
        "DataCut": cut("streaming", "world_left", data(CHANNELS[1]["id"]), "An image lane"),
        "LyingDataCut": cut(
            "streaming",
            "world_left",
            header(KINDS["DATA"], BOUNDS["DATA"], channel=CHANNELS[1]["id"]) + STRING_PAYLOAD,
            "An image lane that claims 16 MiB",
        ),
        "FillerCut": cut("streaming", "link_test", frame("FILLER", b"noise"), "The link test"),
        "SensorDataCut": cut("streaming", "sensors", data(CHANNELS[0]["id"]), "The sensors lane"),
        "TimeRequestCut": cut("streaming", "time", frame("TIME_REQUEST", time), "The time lane"),
    }


def cases() -> dict[str, Case]:
    return data_frames() | cuts()

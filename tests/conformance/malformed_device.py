"""The input of a device from a broken, newer or malicious receiver."""

import math
import struct
from typing import Any

from bodies import (
    BYE,
    CHANNEL,
    CONFIGURE,
    CONFIGURED,
    EVENT,
    HELLO,
    LINK_TEST,
    STATUS,
    STRING_PAYLOAD,
    WELCOME,
    Body,
)
from frame_bytes import BOUNDS, KINDS, UNKNOWN_BOUND, frame, header, json_bytes, json_frame, pascal
from malformed_case import Case, body_frame, error, key_cases, over_bound
from malformed_json import json_cases

MALFORMED = error("malformed")
UNEXPECTED = error("unexpected")
JOINED = {"lane": "sensors"}
START = {"request": 1}


def headers() -> dict[str, Case]:
    """Returns the frames in the place of WELCOME."""
    control = "connected", "control"
    welcome = json_bytes(WELCOME)
    return {
        "BadMagic": Case(
            *control,
            b"HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n",
            MALFORMED,
            "A web server is no receiver.",
        ),
        "NewerVersion": Case(
            *control,
            header(2, len(welcome), version=2) + welcome,
            error("version"),
            "A newer major version.",
        ),
        "LyingLength": Case(
            *control,
            header(2, 2**32 - 1) + welcome,
            error("too_large"),
            "4 GiB are claimed and must not be allocated.",
        ),
        "Silent": Case(
            *control, b"", error("timeout"), "A receiver that accepts and says nothing."
        ),
        "WelcomeThatNeverEnds": Case(
            *control,
            header(2, BOUNDS["WELCOME"]) + welcome,
            error("timeout"),
            "A length within the bound whose bytes do not come.",
        ),
    }


def bounds() -> dict[str, Case]:
    """One byte more than each kind may have; only the header is sent."""
    places = {
        "WELCOME": ("connected", "control"),
        "JOINED": ("connected", "sensors"),
        "CONFIGURE": ("joined", "control"),
        "START": ("configured", "control"),
        "LINK_TEST": ("streaming", "control"),
        "TIME_REPLY": ("joined", "time"),
        "PING": ("streaming", "control"),
        "PONG": ("streaming", "control"),
        "ERROR": ("streaming", "control"),
        "BYE": ("streaming", "control"),
    }
    cases: dict[str, Case] = {}
    for name, place in places.items():
        cases |= over_bound(name, header(KINDS[name], BOUNDS[name] + 1), *place, BOUNDS[name])
    reserved = header(128, UNKNOWN_BOUND + 1)
    return cases | over_bound("KIND_128", reserved, "streaming", "control", UNKNOWN_BOUND)


def skips() -> dict[str, Case]:
    sent = header(128, 4) + STRING_PAYLOAD[:4] + header(191, 0) + header(255, 0)
    return {
        f"UnknownKindsOn{pascal(lane)}": Case(
            "streaming", lane, sent, {"skipped": 3}, "Unknown kinds are skipped and counted."
        )
        for lane in ("control", "time", "sensors", "world_left")
    }


def places() -> dict[str, Case]:
    """Known kinds at a time, on a lane or from a side they are not meant for."""
    mine = {
        "HELLO": ("control", json_frame("HELLO", HELLO)),
        "CONFIGURED": ("control", json_frame("CONFIGURED", CONFIGURED)),
        "CHANNEL": ("control", json_frame("CHANNEL", CHANNEL)),
        "CHANNEL_END": ("control", json_frame("CHANNEL_END", {"id": 7})),
        "STATUS": ("control", json_frame("STATUS", STATUS)),
        "EVENT": ("control", json_frame("EVENT", EVENT)),
        "DATA": ("sensors", frame("DATA", STRING_PAYLOAD, channel=7)),
        "TIME_REQUEST": ("time", frame("TIME_REQUEST", bytes(8))),
        "FILLER": ("control", frame("FILLER", b"noise")),
    }
    from_receiver = {
        f"{pascal(name)}FromReceiver": Case(
            "streaming", lane, sent, UNEXPECTED, f"{name} is the device's."
        )
        for name, (lane, sent) in mine.items()
    }

    def case(given: str, lane: str, sent: bytes, why: str) -> Case:
        return Case(given, lane, sent, UNEXPECTED, why)

    welcome, configure = json_frame("WELCOME", WELCOME), json_frame("CONFIGURE", CONFIGURE)
    start = json_frame("START", START)
    return from_receiver | {
        "ConfigureFirst": case("connected", "control", configure, "WELCOME comes first."),
        "StartFirst": case("connected", "control", start, "WELCOME comes first."),
        "JoinedOnControl": case("connected", "control", json_frame("JOINED", JOINED), "Not asked."),
        "WelcomeOnSensors": case("connected", "sensors", welcome, "JOINED answers JOIN."),
        "JoinedOtherLane": case(
            "connected", "sensors", json_frame("JOINED", {"lane": "time"}), "Another lane's answer."
        ),
        "WelcomeTwice": case("joined", "control", welcome, "One WELCOME a session."),
        "StartBeforeConfigure": case("joined", "control", start, "Nothing is configured."),
        "StartOtherRequest": case(
            "configured", "control", json_frame("START", {"request": 999}), "No such request."
        ),
        "JoinedTwice": case("streaming", "sensors", json_frame("JOINED", JOINED), "Is joined."),
        "TimeReplyOnSensors": case(
            "streaming", "sensors", frame("TIME_REPLY", bytes(24)), "Belongs on time."
        ),
        "LinkTestFirst": case(
            "connected", "control", json_frame("LINK_TEST", LINK_TEST), "WELCOME comes first."
        ),
        "LinkTestOnSensors": case(
            "streaming", "sensors", json_frame("LINK_TEST", LINK_TEST), "Belongs on control."
        ),
        "LinkTestTwice": case(
            "streaming", "control", json_frame("LINK_TEST", LINK_TEST) * 2, "One at a time."
        ),
        "PingOnTime": case("streaming", "time", frame("PING"), "Belongs on control."),
        "SilentSession": Case(
            "streaming", "control", b"", error("timeout"), "Nothing on control for dead_s."
        ),
        "MalformedError": Case(
            "streaming",
            "control",
            json_frame("ERROR", {"code": 5}),
            {"closed": True},
            "An ERROR is never answered, not even a bad one.",
        ),
    }


def keys() -> dict[str, Case]:
    cases = key_cases("WELCOME", "connected", "control", WELCOME)
    for nested in ("timeouts", "limits"):
        cases |= key_cases("WELCOME", "connected", "control", WELCOME, nested=nested)
    return (
        cases
        | key_cases("JOINED", "connected", "sensors", JOINED)
        | key_cases("CONFIGURE", "joined", "control", CONFIGURE)
        | key_cases("START", "configured", "control", START)
        | key_cases("LINK_TEST", "streaming", "control", LINK_TEST)
        | key_cases("BYE", "streaming", "control", BYE)
    )


def bodies() -> dict[str, Case]:
    """Bodies of the right shape with contents that cannot be."""

    def welcome(why: str, code: str = "malformed", **other: Any) -> Case:
        return Case(
            "connected", "control", json_frame("WELCOME", WELCOME | other), error(code), why
        )

    tickets, timeouts = WELCOME["tickets"], WELCOME["timeouts"]
    huge = json_bytes(WELCOME).replace(b'"version":1', b'"version":' + b"9" * 5000)

    def configure(why: str, streams: Any, **other: Any) -> Case:
        sent = body_frame("CONFIGURE", {"request": 1, "streams": streams} | other)
        return Case("joined", "control", sent, MALFORMED, why)

    def bound(most_mbit_per_s: Any) -> Body:
        return {"adapts": True, "most_mbit_per_s": most_mbit_per_s}

    def start_channels(why: str, channels: Any) -> Case:
        sent = json_frame("START", START | {"channels": channels})
        return Case("configured", "control", sent, MALFORMED, why)

    def link_test(why: str, count: Any) -> Case:
        sent = json_frame("LINK_TEST", {"bytes": count})
        return Case("streaming", "control", sent, MALFORMED, why)

    return {
        "LinkTestOfNothing": link_test("At least 1.", 0),
        "LinkTestNegative": link_test("At least 1.", -1),
        "LinkTestEndless": link_test("At most 64 MiB.", 64 * 1024 * 1024 + 1),
        "LinkTestHuge": link_test("Does not fit i64.", 2**63),
        "LinkTestFraction": link_test("It counts.", 1.5),
        "WelcomeOtherVersion": welcome("Was not offered.", "version", version=2),
        "WelcomeVersionHuge": Case(
            "connected", "control", frame("WELCOME", huge), MALFORMED, "Does not fit i64."
        ),
        "WelcomeNoTimeTicket": welcome(
            "The device needs the lane.", tickets={k: v for k, v in tickets.items() if k != "time"}
        ),
        "WelcomeNoSensorsTicket": welcome(
            "The device needs the lane.",
            tickets={k: v for k, v in tickets.items() if k != "sensors"},
        ),
        "WelcomeTicketNumber": welcome("Tickets are strings.", tickets=tickets | {"time": 5}),
        "WelcomeNegativeReceived": welcome("Counts are not negative.", received={"battery": -1}),
        "WelcomeNegativeLimit": welcome("Counts are not negative.", limits={"data_bytes": -1}),
        "WelcomeTimeoutZero": welcome("Would ping for ever.", timeouts=timeouts | {"ping_s": 0}),
        "WelcomeTimeoutNegative": welcome("Not a duration.", timeouts=timeouts | {"dead_s": -1}),
        "WelcomeTimeoutNaN": welcome("JSON has no NaN.", timeouts=timeouts | {"dead_s": math.nan}),
        "ConfigureStreamText": configure("Values are an object.", {"battery": "on"}),
        "ConfigureStreamList": configure("Values are an object.", {"battery": [True]}),
        "ConfigureFramePrefixNumber": configure("It is a string.", {}, frame_prefix=1),
        "ConfigureFramePrefixSpace": configure("No frame id.", {}, frame_prefix="robot 1/"),
        "ConfigureFramePrefixLong": configure("At most 64.", {}, frame_prefix="a" * 65),
        "ConfigureLinkText": configure("It is an object.", {}, link="auto"),
        "ConfigureLinkEmpty": configure("It says whether the device adapts.", {}, link={}),
        "ConfigureLinkAdaptsNumber": configure("It is a boolean.", {}, link={"adapts": 1}),
        "ConfigureLinkBoundZero": configure("Nothing could be sent.", {}, link=bound(0)),
        "ConfigureLinkBoundNegative": configure("Not a throughput.", {}, link=bound(-1)),
        "ConfigureLinkBoundText": configure("It is a number.", {}, link=bound("100")),
        "StartChannelsText": start_channels("It is a number.", "5"),
        "StartChannelsFraction": start_channels("It counts.", 1.5),
        "StartChannelsNegative": start_channels("Counts are not negative.", -1),
        "TimeReplyShort": Case(
            "joined", "time", frame("TIME_REPLY", bytes(23)), MALFORMED, "t1, t2, t3 have 24 bytes."
        ),
        "TimeReplyEmpty": Case(
            "joined", "time", frame("TIME_REPLY"), MALFORMED, "t1, t2, t3 have 24 bytes."
        ),
    }


def cuts() -> dict[str, Case]:
    """The receiver's output ends after each number of bytes short of the whole."""

    def cut(given: str, lane: str, sent: bytes, what: str) -> Case:
        return Case(given, lane, sent, {"closed": True}, f"{what} ends inside the frame.", cut=True)

    times = struct.pack("<q", 1) + struct.pack("<q", 2) + struct.pack("<q", 3)
    return {
        "WelcomeCut": cut("connected", "control", json_frame("WELCOME", {"version": 1}), "Control"),
        "JoinedCut": cut("connected", "sensors", json_frame("JOINED", JOINED), "The sensors lane"),
        "StartCut": cut("configured", "control", json_frame("START", START), "Control"),
        "TimeReplyCut": cut("joined", "time", frame("TIME_REPLY", times), "The time lane"),
    }


def cases() -> dict[str, Case]:
    return (
        headers()
        | bounds()
        | skips()
        | places()
        | json_cases("WELCOME", "connected", "control", WELCOME, "name")
        | keys()
        | bodies()
        | cuts()
    )

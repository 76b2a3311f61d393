"""Known frames at a time, on a lane, from a side or with a ticket they are not meant for."""

from bodies import (
    BYE,
    CHANNEL,
    CONFIGURE,
    CONFIGURED,
    EVENT,
    HELLO,
    JOIN,
    LINK_TEST,
    SESSION,
    STATUS,
    TICKET,
    WELCOME,
)
from frame_bytes import frame, header, json_frame, pascal
from malformed_case import Case, body_frame, error
from malformed_receiver import data


def places() -> dict[str, Case]:
    """Known kinds at a time, on a lane or from a side they are not meant for."""
    unexpected = error("unexpected")
    cases = {}
    first = {
        "UNKNOWN": header(99, 0),
        "PING": frame("PING"),
        "DATA": data(CHANNEL["id"]),
        "STATUS": json_frame("STATUS", STATUS),
        "TIME_REQUEST": frame("TIME_REQUEST", bytes(8)),
        "CHANNEL": json_frame("CHANNEL", CHANNEL),
    }
    for name, sent in first.items():
        cases[f"{pascal(name)}First"] = Case(
            "connected", "control", sent, unexpected, "A connection begins with HELLO or JOIN."
        )
    theirs = {
        "WELCOME": json_frame("WELCOME", WELCOME),
        "CONFIGURE": json_frame("CONFIGURE", CONFIGURE),
        "START": json_frame("START", {"request": 1}),
        "LINK_TEST": json_frame("LINK_TEST", LINK_TEST),
        "JOINED": json_frame("JOINED", {"lane": "sensors"}),
        "TIME_REPLY": frame("TIME_REPLY", bytes(24)),
    }
    lanes = {"JOINED": "sensors", "TIME_REPLY": "time"}
    for name, sent in theirs.items():
        cases[f"{pascal(name)}FromDevice"] = Case(
            "streaming", lanes.get(name, "control"), sent, unexpected, f"{name} is the receiver's."
        )
    elsewhere = [
        ("DATA", "control", data(CHANNEL["id"])),
        ("DATA", "time", data(CHANNEL["id"])),
        ("DATA", "link_test", data(CHANNEL["id"])),
        ("FILLER", "control", frame("FILLER", b"noise")),
        ("FILLER", "sensors", frame("FILLER", b"noise")),
        ("FILLER", "world_left", frame("FILLER", b"noise")),
        ("TIME_REQUEST", "control", frame("TIME_REQUEST", bytes(8))),
        ("TIME_REQUEST", "sensors", frame("TIME_REQUEST", bytes(8))),
        ("STATUS", "sensors", json_frame("STATUS", STATUS)),
        ("EVENT", "sensors", json_frame("EVENT", EVENT)),
        ("PING", "time", frame("PING")),
        ("BYE", "world_left", json_frame("BYE", BYE)),
        ("HELLO", "sensors", json_frame("HELLO", HELLO)),
        ("JOIN", "control", body_frame("JOIN", JOIN | {"lane": "control"})),
    ]
    for name, lane, sent in elsewhere:
        cases[f"{pascal(name)}On{pascal(lane)}"] = Case(
            "streaming", lane, sent, unexpected, f"{name} does not belong on lane {lane}."
        )
    return cases


def order() -> dict[str, Case]:
    """Kinds that come too early or twice."""
    unexpected = error("unexpected")
    return {
        "HelloTwice": Case(
            "welcomed", "control", json_frame("HELLO", HELLO), unexpected, "One HELLO a session."
        ),
        "JoinTwice": Case(
            "streaming", "sensors", body_frame("JOIN", JOIN), unexpected, "The lane is joined."
        ),
        "ChannelBeforeConfigure": Case(
            "welcomed",
            "control",
            json_frame("CHANNEL", CHANNEL),
            unexpected,
            "No stream has been asked for.",
        ),
        "ConfiguredBeforeConfigure": Case(
            "welcomed",
            "control",
            json_frame("CONFIGURED", CONFIGURED),
            unexpected,
            "No request is open.",
        ),
        "FillerNotAskedFor": Case(
            "streaming", "link_test", frame("FILLER", b"noise"), unexpected, "No LINK_TEST came."
        ),
        "FillerEndNotAskedFor": Case(
            "streaming", "link_test", frame("FILLER"), unexpected, "There is no test to end."
        ),
        "DataBeforeStart": Case(
            "configuring", "sensors", data(CHANNEL["id"]), unexpected, "Not started."
        ),
        "NoLanes": Case(
            "welcomed",
            "control",
            b"",
            error("timeout"),
            "`time` and `sensors` are not joined in time.",
        ),
        "SilentSession": Case(
            "streaming", "control", b"", error("timeout"), "Nothing on control for dead_s."
        ),
        "SilentSessionInFrame": Case(
            "streaming",
            "control",
            json_frame("BYE", BYE)[:-1],
            error("timeout"),
            "A frame that is not complete does not keep a session alive.",
        ),
        "ErrorFirst": Case(
            "connected",
            "control",
            json_frame("ERROR", {"code": "busy", "message": "no", "fatal": True}),
            {"closed": True},
            "An ERROR is never answered.",
        ),
        "MalformedError": Case(
            "streaming",
            "control",
            json_frame("ERROR", {"code": 5}),
            {"closed": True},
            "An ERROR is never answered, not even a bad one.",
        ),
    }


def tickets() -> dict[str, Case]:
    """JOINs that open no lane; SESSION and TICKET are those of a session that goes on."""
    zeros = "0" * 32

    def join(why: str, **other: str) -> Case:
        sent = body_frame("JOIN", JOIN | {"lane": "color"} | other)
        return Case("connected", "color", sent, error("ticket"), why)

    return {
        "UsedTicket": Case(
            "connected",
            "sensors",
            body_frame("JOIN", JOIN),
            error("ticket"),
            "The session has opened its sensors lane.",
        ),
        "UnknownTicket": join("Not a ticket of the session.", ticket=zeros),
        "EmptyTicket": join("Not a ticket of the session.", ticket=""),
        "UnknownSession": join("JOIN without a session.", session=zeros),
        "TicketOfOtherLane": join("The ticket opens another lane.", lane="infra"),
        "ControlTicket": join("No ticket opens control.", lane="control"),
        "UnknownLane": join("No stream has this name.", lane="color_2"),
        "SessionAsTicket": join("Session and ticket swapped.", session=TICKET, ticket=SESSION),
    }


def cases() -> dict[str, Case]:
    return places() | order() | tickets()

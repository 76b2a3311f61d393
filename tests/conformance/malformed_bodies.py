"""Bodies with wrong contents that a receiver gets, and frames that end too early."""

import math
from typing import Any

from bodies import CHANNEL, CHANNELS, CONFIGURED_LIVE, HELLO, REQUEST, STATUS
from frame_bytes import frame, json_bytes, json_frame
from malformed_case import Case, body_frame, error, key_cases
from malformed_json import json_cases
from malformed_receiver import DEVICE_KINDS

MALFORMED = error("malformed")


def keys() -> dict[str, Case]:
    cases: dict[str, Case] = {}
    for name, (body, given, lane) in DEVICE_KINDS.items():
        cases |= key_cases(name, given, lane, body)
    cases |= key_cases("HELLO", "connected", "control", HELLO, nested="capabilities")
    cases |= key_cases("STATUS", "streaming", "control", STATUS, nested="clock")
    return cases


def hellos() -> dict[str, Case]:
    def case(code: str, why: str, **other: Any) -> Case:
        return Case("connected", "control", json_frame("HELLO", HELLO | other), error(code), why)

    return {
        "HelloNoVersions": case("version", "No version is common.", versions=[]),
        "HelloNewerVersions": case("version", "No version is common.", versions=[2, 3]),
        "HelloOtherDevice": case("busy", "Another device is connected.", device_id="other"),
        "HelloVersionBeforeBusy": case(
            "version", "It could not be served later either.", device_id="other", versions=[2]
        ),
        "HelloVersionText": case("malformed", "Versions are integers.", versions=["1"]),
        "HelloVersionTrue": case("malformed", "true is not an integer.", versions=[True]),
        "HelloVersionFraction": case("malformed", "1.0 is not an integer literal.", versions=[1.0]),
        "HelloVersionHuge": Case(
            "connected",
            "control",
            frame("HELLO", json_bytes(HELLO).replace(b"[1]", b"[" + b"9" * 5000 + b"]")),
            MALFORMED,
            "Fits neither i64 nor the digit limit of careless parsers.",
        ),
        "HelloNameEmpty": case("malformed", "People have to know it by something.", name=""),
        "HelloNameTooLong": case("malformed", "65 characters.", name="x" * 65),
        "HelloNameWithEscape": case("malformed", "Would move a terminal's cursor.", name="\x1b[2J"),
        "HelloSoftwareTooLong": case("malformed", "129 characters.", software="x" * 129),
        "HelloPermissionText": case(
            "malformed", "Permissions are true or false.", permissions={"a": "true"}
        ),
        "HelloStreamNumber": case(
            "malformed", "Stream ids are strings.", capabilities={"streams": [7]}
        ),
    }


def channels() -> dict[str, Case]:
    """CHANNELs that are not rows of the stream table, or are announced already."""

    def case(code: str, why: str, *bodies: dict[str, Any], given: str = "configuring") -> Case:
        sent = b"".join(json_frame("CHANNEL", body) for body in bodies)
        return Case(given, "control", sent, error(code), why)

    def changed(why: str, code: str = "channel", **other: Any) -> Case:
        return case(code, why, CHANNEL | other)

    image = CHANNELS[1]
    gaze = {
        "stream": "gaze",
        "role": "pose",
        "topic": "gaze",
        "type": "geometry_msgs/msg/PoseStamped",
    }
    return {
        "ChannelUnknownStream": changed("Not a stream.", stream="battery_2"),
        "ChannelNotAskedFor": changed("A stream that CONFIGURE does not name.", **gaze),
        "ChannelOtherRole": changed("Not a role of the stream.", role="image"),
        "ChannelOtherTopic": changed("Not the table's topic.", topic="world_left/image_raw"),
        "ChannelGlobalTopic": changed("A device cannot name topics.", topic="/rosout"),
        "ChannelOtherType": changed("Not the table's type.", type="std_msgs/msg/String"),
        "ChannelOtherQos": changed("Not the table's QoS.", qos="latched"),
        "ChannelOtherLane": changed("A small topic on an image lane.", lane="world_left"),
        "ChannelTableLane": case(
            "channel",
            "A lane bears its stream's id, not the word `image`.",
            image | {"lane": "image"},
        ),
        "ChannelIdZero": changed("Ids are 1 to 65535.", "malformed", id=0),
        "ChannelIdTooLarge": changed("Ids are 1 to 65535.", "malformed", id=65536),
        "ChannelIdNegative": changed("Ids are 1 to 65535.", "malformed", id=-1),
        "ChannelIdFraction": changed("Ids are integers.", "malformed", id=7.5),
        "ChannelIdBoolean": changed("true is not an integer.", "malformed", id=True),
        "ChannelSameId": case(
            "channel", "The id is another topic's.", CHANNEL, image | {"id": CHANNEL["id"]}
        ),
        "ChannelSameTopic": case("channel", "The topic has an id.", CHANNEL, CHANNEL | {"id": 99}),
        "ChannelAnnouncedAgain": case(
            "channel", "A topic that stays is not announced again.", CHANNEL, given="streaming"
        ),
        "ChannelOtherId": Case(
            "streaming",
            "control",
            json_frame("CHANNEL_END", {"id": CHANNEL["id"]})
            + json_frame("CHANNEL", CHANNEL | {"id": 99}),
            error("channel"),
            "A topic keeps its id; else the receiver would have to know any number of them.",
        ),
        "ChannelEndUnknown": Case(
            "streaming",
            "control",
            json_frame("CHANNEL_END", {"id": 65535}),
            error("channel"),
            "No such channel was announced.",
        ),
        "ChannelEndTwice": Case(
            "streaming",
            "control",
            json_frame("CHANNEL_END", {"id": 7}) * 2,
            error("channel"),
            "The channel has ended.",
        ),
    }


def answers() -> dict[str, Case]:
    """CONFIGURED bodies that do not answer what was asked."""
    streams = CONFIGURED_LIVE["streams"]

    def case(
        why: str, changed: dict[str, Any], code: str = "malformed", request: Any = REQUEST
    ) -> Case:
        sent = body_frame("CONFIGURED", {"request": request, "streams": changed})
        return Case("configuring", "control", sent, error(code), why)

    return {
        "ConfiguredOtherRequest": case(
            "No such request is open.", streams, "unexpected", 1_000_000_007
        ),
        "ConfiguredMissingStream": case(
            "The stream tf has no answer.", {k: streams[k] for k in streams if k != "tf"}
        ),
        "ConfiguredAdditionalStream": case(
            "gaze was not asked for.", streams | {"gaze": streams["tf"]}
        ),
        "ConfiguredUnknownResult": case(
            "Not a result.", streams | {"tf": {"result": "perhaps", "values": {}, "reason": "x"}}
        ),
        "ConfiguredRefusedWithoutReason": case(
            "A refusal says why.", streams | {"tf": {"result": "refused"}}
        ),
        "ConfiguredAdjustedWithoutReason": case(
            "An adjustment says why.", streams | {"tf": {"result": "adjusted", "values": {}}}
        ),
        "ConfiguredAppliedWithoutValues": case(
            "What is applied is told.", streams | {"tf": {"result": "applied"}}
        ),
        "ConfiguredAnswerIsText": case("An answer is an object.", streams | {"tf": "applied"}),
        "ConfiguredTwice": Case(
            "streaming",
            "control",
            json_frame("CONFIGURED", CONFIGURED_LIVE | {"request": 1}),
            error("unexpected"),
            "The request is answered.",
        ),
    }


def others() -> dict[str, Case]:
    def status(why: str, **other: Any) -> Case:
        return Case("streaming", "control", json_frame("STATUS", STATUS | other), MALFORMED, why)

    def stream(why: str, **lowered: Any) -> Case:
        return status(why, streams={"world_left": {"state": "running"} | lowered})

    counts = {"produced": 1, "sent": 1, "dropped": {}}
    return {
        "TimeRequestShort": Case(
            "streaming", "time", frame("TIME_REQUEST", bytes(7)), MALFORMED, "t1 has 8 bytes."
        ),
        "TimeRequestEmpty": Case(
            "streaming", "time", frame("TIME_REQUEST"), MALFORMED, "t1 has 8 bytes."
        ),
        "StatusNegativeCount": status(
            "Counts are not negative.", channels={"battery": counts | {"sent": -1}}
        ),
        "StatusNegativeDrops": status(
            "Counts are not negative.",
            channels={"battery": counts | {"dropped": {"queue_full": -1}}},
        ),
        "StatusCountTooLarge": status(
            "Counts fit i64.", channels={"battery": counts | {"produced": 2**63}}
        ),
        "StatusFractionalCount": status(
            "Counts are integers.", channels={"battery": counts | {"produced": 1.5}}
        ),
        "StatusCountsMissing": status(
            "Each channel has three.", channels={"battery": {"produced": 1}}
        ),
        "StatusUptimeNaN": status("JSON has no NaN.", uptime_s=math.nan),
        "StatusUptimeOverflow": Case(
            "streaming",
            "control",
            frame("STATUS", json_bytes(STATUS).replace(b"12.5", b"1e400")),
            MALFORMED,
            "Not finite in a double.",
        ),
        "StatusUnknownThermal": status("Not a grade of Android's.", thermal="hot"),
        "StatusUnknownStreamState": status(
            "Not a state.", streams={"battery": {"state": "asleep"}}
        ),
        "StatusStreamWithoutState": status(
            "Each stream has a state.", streams={"battery": {"reason": "asleep"}}
        ),
        "StatusStreamReasonTooLong": status(
            "At most 200 characters.",
            streams={"battery": {"state": "waiting", "reason": "x" * 201}},
        ),
        "StatusStreamPermissionTooLong": status(
            "At most 128 characters.",
            streams={"battery": {"state": "waiting", "permission": "x" * 129}},
        ),
        "StatusStreamPermissionNotPrintable": status(
            "It is shown in a command.",
            streams={"battery": {"state": "waiting", "permission": "a\nb"}},
        ),
        "StatusStreamQualityZero": stream("At least 1.", quality=0),
        "StatusStreamQualityTooLarge": stream("At most 100.", quality=101),
        "StatusStreamQualityFraction": stream("It is an integer.", quality=60.5),
        "StatusStreamRateZero": stream("At least 1.", rate_hz=0),
        "StatusStreamRateNegative": stream("At least 1.", rate_hz=-15),
        "StatusStreamRateText": stream("It is a number.", rate_hz="15"),
        "StatusUnknownClockState": status(
            "Not a state.", clock=STATUS["clock"] | {"state": "guessed"}
        ),
    }


def cases() -> dict[str, Case]:
    return (
        json_cases("HELLO", "connected", "control", HELLO, "name")
        | keys()
        | hellos()
        | channels()
        | answers()
        | others()
    )

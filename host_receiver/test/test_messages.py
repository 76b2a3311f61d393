import dataclasses
import json
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ml2_receiver.errors import ProtocolError
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.messages import (
    Bye,
    Capabilities,
    Channel,
    ChannelEnd,
    ChannelStatus,
    ClockStatus,
    Configure,
    Configured,
    Error,
    Event,
    Hello,
    Join,
    Joined,
    Link,
    LinkTest,
    PeerLimits,
    Start,
    Status,
    StreamAnswer,
    StreamStatus,
    Timeouts,
    Welcome,
)
from ml2_receiver.wire.pairing_bodies import Pair, PairChallenge, Paired

BODIES: list[JsonBody] = [
    Hello([1, 2], "id", "run", "Zoë \U0001f97d", "app", Capabilities(["tf"]), {"CAMERA": True}),
    Welcome(1, "s", "host", "x", {"time": "t"}, None, PeerLimits(1), Timeouts(5.0, 1.0, 2.0)),
    Welcome(1, "s", "host", "x", {}, {"/tf": 3}, PeerLimits(1), Timeouts(5.0, 1.5, 2.0)),
    Join("s", "t", "time"),
    Joined("time"),
    Configure(1, {"tf": {"layout": "flat"}, "depth": {"radial": True, "x": 1, "y": 0.5}}),
    Configure(2, {}, "robot1/", Link(adapts=True, most_mbit_per_s=0.5)),
    Configured(
        1,
        {
            "tf": StreamAnswer("applied", {"layout": "flat"}),
            "depth": StreamAnswer("adjusted", {"update_rate": 30}, "slower"),
            "color": StreamAnswer("refused", reason="covered"),
        },
    ),
    Channel(65535, "tf", "tf", "/tf", "tf2_msgs/msg/TFMessage", "tf", "", "sensors"),
    ChannelEnd(1),
    Start(2**63 - 1),
    LinkTest(1),
    Status(
        True, 0.5, {"/tf": ChannelStatus(3, 2, {"queue_full": 1})}, ClockStatus("frozen", -1, 2, 3)
    ),
    Status(
        False,
        0.5,
        {},
        ClockStatus("holdover", -1, 2, 3, -49.5, 1, 2, {"color": "monotonic", "tf": "boottime"}),
        streams={"world_left": StreamStatus("running", quality=60, rate_hz=15)},
    ),
    Event("tracking_lost", "the head"),
    Error("busy", "later", fatal=True),
    Bye(""),
]
STATUS = json.loads(BODIES[-4].to_bytes())
NAMED = [
    *BODIES[:2],
    PairChallenge("0" * 64, "desk", "ml2-receiver"),
    Pair("0" * 32, "Magic Leap 2", "id", "certificate", "signature"),
    Paired("desk", 7755),
]


@pytest.mark.parametrize("body", BODIES, ids=lambda body: type(body).__name__)
def test_unknown_keys_are_ignored(body: JsonBody) -> None:
    document = {"later": [{"deep": None}], **json.loads(body.to_bytes())}
    assert type(body).parse(json.dumps(document).encode()) == body


@pytest.mark.parametrize("body", NAMED, ids=lambda body: type(body).__name__)
@pytest.mark.parametrize("wrong", ["", "a\x1b]52;c;eA==\x07", "a\nb", "x" * 129])
def test_names_are_printable_and_short(body: JsonBody, wrong: str) -> None:
    document = json.loads(body.to_bytes())
    for key in {"name", "software", "device_id", "instance_id"} & document.keys():
        with pytest.raises(ProtocolError, match=f"{key}: expected 1 to"):
            type(body).parse(json.dumps({**document, key: wrong}).encode())


@pytest.mark.parametrize("body", BODIES, ids=lambda body: type(body).__name__)
def test_every_key_is_needed_in_its_type(body: JsonBody) -> None:
    document = json.loads(body.to_bytes())
    assert document
    for field in dataclasses.fields(body):  # type: ignore[arg-type]
        if field.default is dataclasses.MISSING:
            without = {key: value for key, value in document.items() if key != field.name}
            with pytest.raises(ProtocolError, match=rf"body\.{field.name}: missing"):
                type(body).parse(json.dumps(without).encode())
        with pytest.raises(ProtocolError, match=rf"body\.{field.name}"):
            type(body).parse(json.dumps(document | {field.name: [[]]}).encode())


def parse_status(**changes: Any) -> Status:
    return Status.parse(json.dumps(STATUS | changes).encode())


def stream(**lowered: Any) -> dict[str, Any]:
    return {"streams": {"color": {"state": "running"} | lowered}}


@pytest.mark.parametrize("most", [0, -1, -0.5])
def test_a_bound_of_the_link_is_above_0(most: float) -> None:
    body = json.dumps({"request": 1, "streams": {}, "link": link(most)}).encode()
    with pytest.raises(ProtocolError, match="most_mbit_per_s: expected a number above 0"):
        Configure.parse(body)


def link(most_mbit_per_s: float) -> dict[str, Any]:
    return {"adapts": True, "most_mbit_per_s": most_mbit_per_s}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"final": 1}, "body.final: expected bool, found int '1'"),
        ({"uptime_s": True}, "body.uptime_s: expected float, found bool 'True'"),
        ({"uptime_s": 10**400}, "body.uptime_s: expected a finite number"),
        ({"clock": STATUS["clock"] | {"offset_ns": 2**63}}, "offset_ns: expected a 64-bit integer"),
        ({"clock": STATUS["clock"] | {"offset_ns": 1.0}}, "offset_ns: expected int, found float"),
        ({"clock": STATUS["clock"] | {"state": "late"}}, "expected one of waiting, synchronised"),
        ({"clock": STATUS["clock"] | {"skew_ppm": "1"}}, "clock.skew_ppm: expected"),
        ({"clock": STATUS["clock"] | {"skew_ppm": 10**400}}, "skew_ppm"),
        ({"clock": STATUS["clock"] | {"steps": -1}}, "not negative"),
        ({"clock": STATUS["clock"] | {"epoch": -1}}, "not negative"),
        ({"clock": STATUS["clock"] | {"epoch": 1.0}}, "clock.epoch: expected"),
        ({"clock": STATUS["clock"] | {"bases": {"color": "realtime"}}}, "clock.bases"),
        ({"clock": STATUS["clock"] | {"bases": ["color"]}}, "clock.bases"),
        ({"channels": {"/tf": {"produced": 1, "sent": 1, "dropped": {"x": -1}}}}, "not negative"),
        ({"channels": {"/tf": {"produced": -1, "sent": 1, "dropped": {}}}}, "not negative"),
        ({"thermal": "hot"}, "body.thermal: expected"),
        (stream(quality=0), "quality: expected 1 to 100, found 0"),
        (stream(quality=101), "quality: expected 1 to 100, found 101"),
        (stream(quality=60.0), "streams.color.quality: expected"),
        (stream(rate_hz=0), "rate_hz: expected at least 1, found 0"),
        (stream(rate_hz=-1), "rate_hz: expected at least 1, found -1"),
        (stream(rate_hz="15"), "streams.color.rate_hz: expected"),
        ({"channels": [1]}, "body.channels: expected dict, found list$"),
    ],
)
def test_a_wrong_value_is_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ProtocolError, match=message) as raised:
        parse_status(**changes)
    assert raised.value.code == "malformed"


def test_a_whole_number_is_a_number() -> None:
    assert parse_status(uptime_s=3).uptime_s == 3.0


@pytest.mark.parametrize("body", [b'"reason"', b'{"reason":"","\\udfff":1}'])
def test_a_text_and_a_lone_surrogate_in_a_key_are_malformed(body: bytes) -> None:
    with pytest.raises(ProtocolError) as raised:
        Bye.parse(body)
    assert raised.value.code == "malformed"


@given(body=st.binary(max_size=100), kind=st.sampled_from([type(body) for body in BODIES]))
def test_garbage_is_malformed(body: bytes, kind: type[JsonBody]) -> None:
    with pytest.raises(ProtocolError):
        kind.parse(body)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


@given(data=st.data(), body=st.sampled_from(BODIES))
def test_a_replaced_value_is_taken_or_malformed(data: st.DataObject, body: JsonBody) -> None:
    document = json.loads(body.to_bytes())
    key = data.draw(st.sampled_from(sorted(document)))
    document[key] = data.draw(JSON)
    with suppress(ProtocolError):
        parsed = type(body).parse(json.dumps(document).encode())
        assert type(parsed).parse(parsed.to_bytes()) == parsed

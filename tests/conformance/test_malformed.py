"""The receiver's side of vectors/malformed, played over loopback to a receiver without ROS."""

import gc
import threading
import tracemalloc
from collections.abc import Iterator
from typing import Any

import pytest

from bodies import CHANNELS, CONFIGURE, STRING_PAYLOAD
from case_files import Vector, load, named
from fake_sink import FakeGraph
from frame_bytes import frame
from ml2_receiver.configuration.app_rules import AppRules, NameRules
from ml2_receiver.session.report import Report
from ml2_receiver.session.server import Server
from ml2_receiver.session.settings import Limits, ReceiverSettings
from ml2_receiver.session.sink import Applied, Publish
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Topic
from ml2_receiver.transport.access import Everybody
from ml2_receiver.transport.listener import listen
from scripted_device import Address, Peer, ScriptedDevice, StreamingDevice
from waiting import LIMIT_S

CASES = named("malformed", "Receiver*")
PATIENT = Limits(handshake_s=20.0, dead_s=20.0, linger_s=0.5)
IMPATIENT = Limits(handshake_s=3.0, dead_s=3.0, linger_s=0.5)
RULES = AppRules(
    subscribe=NameRules(("/robot/**", "/tf")),
    call=NameRules(("/robot/*",)),
    offer=NameRules(("/headset/*",)),
)
# The limit of memory for a case; frames that claim up to 4 GiB are among them.
MEMORY_BYTES = 4 << 20


class CountingSink:
    """Takes everything, counts payloads and sessions, keeps events."""

    def __init__(self) -> None:
        self.events: list[str] = []
        self.published = 0
        self.ended_sessions = 0
        self._arrival = threading.Condition()

    def open(self, topic: Topic) -> Publish:
        return self._publish

    def _publish(self, payload: bytearray) -> None:
        with self._arrival:
            self.published += 1
            self._arrival.notify_all()

    def await_published(self, total: int) -> None:
        with self._arrival:
            assert self._arrival.wait_for(lambda: self.published >= total, LIMIT_S)

    def await_ended_sessions(self, total: int) -> None:
        with self._arrival:
            assert self._arrival.wait_for(lambda: self.ended_sessions >= total, LIMIT_S)

    def configured(self, applied: Applied) -> None:
        pass

    def event(self, text: str) -> None:
        with self._arrival:
            self.events.append(text)
            self._arrival.notify_all()

    def await_event(self, text: str) -> None:
        with self._arrival:
            assert self._arrival.wait_for(
                lambda: any(text in event for event in self.events), LIMIT_S
            )

    def session_ended(self, report: Report) -> None:
        with self._arrival:
            self.ended_sessions += 1
            self._arrival.notify_all()


@pytest.fixture
def sink() -> CountingSink:
    return CountingSink()


@pytest.fixture
def receiver(sink: CountingSink, request: pytest.FixtureRequest) -> Iterator[Server]:
    """Is impatient only where a case waits for the end of its patience."""
    vector = getattr(request.node, "callspec", None)
    expected = vector.params["vector"].case["expect"] if vector else {}
    limits = IMPATIENT if expected == {"error": "timeout"} else PATIENT
    server = Server(
        listen(("127.0.0.1", 0)),
        Everybody(),
        sink,
        CONFIGURE["streams"],
        ReceiverSettings("test", "test", limits=limits, app=lambda: RULES, graph=FakeGraph()),
    )
    server.start()
    yield server
    server.stop()


@pytest.fixture
def address(receiver: Server) -> Address:
    host, port = receiver.address.split(":")
    return host, int(port)


@pytest.fixture(autouse=True)
def bounded_memory() -> Iterator[None]:
    gc.freeze()  # collecting is quick when only what this test made is looked at
    tracemalloc.start()
    yield
    _, peak_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    gc.unfreeze()
    assert peak_bytes < MEMORY_BYTES


@pytest.mark.parametrize("vector", CASES, ids=lambda vector: vector.name)
def test_faulty_devices_are_refused_and_good_ones_served(
    vector: Vector, receiver: Server, sink: CountingSink, address: Address
) -> None:
    _, case, binary = vector
    attempts = [binary[:end] for end in range(1, len(binary))] if case.get("cut") else [binary]
    if case["given"] != "connected":
        for count, sent in enumerate(attempts, 1):
            with ScriptedDevice(address) as faulty:
                faulty.reach(case["given"], ros=case.get("ros", False))
                peer = faulty.lanes[case["lane"]]
                play(case, peer, faulty.fill_in(sent, case["lane"]))
                check(case, peer, receiver, sink)
            sink.await_ended_sessions(count)
            gc.collect()  # what a session cost is free before the next costs as much
        attempts = []
    with StreamingDevice(address) as good:
        for sent in attempts:
            peer = Peer(address)
            play(case, peer, good.fill_in(sent, case["lane"]))
            check(case, peer, receiver, sink)
            peer.close()
        sink.await_published(sink.published + 3)
        assert good.control.read_until("PONG").name == "PONG"


def play(case: dict[str, Any], peer: Peer, sent: bytes) -> None:
    peer.send(sent)
    if case.get("cut"):
        peer.finish_writing()


def check(case: dict[str, Any], peer: Peer, receiver: Server, sink: CountingSink) -> None:
    """Checks that the case's expected result came and that its reason is logged."""
    match case["expect"]:
        case {"error": code}:
            error = peer.expect("ERROR").json
            assert (error["code"], error["fatal"]) == (code, True), error
            assert peer.read().name is None
            sink.await_event(error["message"])
        case {"closed": True}:
            assert peer.read_until(None).name is None
            sink.await_event("")
        case {"refused": id}:
            answer = peer.expect("OPENED").json
            while answer["id"] != id:
                assert answer["result"] == "opened", answer
                answer = peer.expect("OPENED").json
            assert answer["result"] == "refused", answer
            check_lane_goes_on(case["lane"], peer, sink)
        case {"failure": code}:
            assert peer.expect("FAILURE").json["code"] == code
            check_lane_goes_on(case["lane"], peer, sink)
        case {"skipped": _} | {"late": _}:
            check_lane_goes_on(case["lane"], peer, sink)
            report = receiver.report()
            assert report is not None
            found = {"skipped": report.skipped_frames, "late": report.openings.late}
            assert found == {"skipped": 0, "late": 0} | case["expect"]


def check_lane_goes_on(lane: str, peer: Peer, sink: CountingSink) -> None:
    match lane:
        case "control":
            peer.send(frame("PING"))
            peer.expect("PONG")
        case "link_test":
            peer.send(frame("FILLER"))
            assert peer.expect("ERROR").json["code"] == "unexpected"
        case "ros":
            request = frame("REQUEST", bytes([0, 1, 0, 0, 0]), channel=3, sequence=99, capture=0)
            peer.send(request)
            assert peer.expect("ERROR").json["code"] == "malformed"
        case "bulk_1":
            peer.send(frame("TAKEN", channel=2))
            assert peer.expect("ERROR").json["code"] == "unexpected"
        case "time":
            peer.send(frame("TIME_REQUEST", bytes(8)))
            peer.expect("TIME_REPLY")
        case _:
            channel = next(body["id"] for body in CHANNELS if body["lane"] == lane)
            peer.send(frame("DATA", STRING_PAYLOAD, channel=channel))
            sink.await_published(1)


def test_a_device_of_before_openings_is_welcomed_as_before(address: Address) -> None:
    peer = Peer(address)
    peer.send(load("wire")["Hello"].data)
    welcome = peer.expect("WELCOME").json
    assert welcome.keys() == load("wire")["Welcome"].case["frames"][0]["json"].keys()
    assert welcome["tickets"].keys() == {"time", "link_test", *load_table().lanes}
    peer.close()

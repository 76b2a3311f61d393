"""A device played by hand, with frame_bytes and a reader of its own."""

import json
import secrets
import socket
import struct
import threading
from contextlib import suppress
from typing import Any, NamedTuple, Self

from bodies import (
    CHANNELS,
    CONFIGURED,
    HELLO,
    OPENINGS,
    REQUEST,
    SESSION,
    STRING_PAYLOAD,
    TICKET,
)
from frame_bytes import KINDS, frame, json_frame
from waiting import LIMIT_S

Address = tuple[str, int]
# Longer than any limit of the receiver under test.
_NAMES = {number: name for name, number in KINDS.items()}


class Received(NamedTuple):
    """A frame that came; `name` is None for the end of the connection."""

    name: str | None
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)


class Peer:
    """One connection."""

    def __init__(self, address: Address) -> None:
        self._socket = socket.create_connection(address, LIMIT_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._input = self._socket.makefile("rb")

    def send(self, data: bytes) -> None:
        """Best effort: the receiver may have closed already."""
        with suppress(ConnectionError):
            self._socket.sendall(data)

    def finish_writing(self) -> None:
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_WR)

    def read(self) -> Received:
        try:
            head = self._input.read(32)
            if len(head) < 32:
                return Received(None, b"")
            (length,) = struct.unpack_from("<I", head, 12)
            return Received(_NAMES[head[3]], self._input.read(length))
        except ConnectionError:
            return Received(None, b"")

    def read_until(self, *names: str | None) -> Received:
        while True:
            found = self.read()
            if found.name in names or found.name is None:
                return found

    def expect(self, name: str) -> Received:
        found = self.read_until(name, "ERROR")
        assert found.name == name, f"expected {name}, found {found}"
        return found

    def close(self) -> None:
        self._socket.close()
        self._input.close()


class ScriptedDevice:
    """One session, taken to a state of README.md; ends when left."""

    def __init__(self, address: Address) -> None:
        self._address = address
        self._welcome: dict[str, Any] = {}
        self._request = 0
        self.lanes: dict[str, Peer] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for peer in self.lanes.values():
            peer.close()

    @property
    def control(self) -> Peer:
        return self.lanes["control"]

    @property
    def session(self) -> str:
        session: str = self._welcome["session"]
        return session

    def reach(self, given: str, *, ros: bool = False) -> None:
        """Goes from `connected` to `welcomed`, `configuring`, `streaming` or `opened`."""
        self.lanes["control"] = Peer(self._address)
        changes: dict[str, Any] = {"instance_id": secrets.token_hex(8)}
        if ros or given == "opened":
            changes["capabilities"] = HELLO["capabilities"] | {"ros": True}
        self.control.send(json_frame("HELLO", HELLO | changes))
        self._welcome = self.control.expect("WELCOME").json
        if given == "welcomed":
            return
        self.join("time")
        self.join("sensors")
        self._request = self.control.expect("CONFIGURE").json["request"]
        if given == "configuring":
            return
        self.join("link_test")
        self.join("world_left")
        for body in CHANNELS:
            self.control.send(json_frame("CHANNEL", body))
        self.control.send(json_frame("CONFIGURED", CONFIGURED | {"request": self._request}))
        self.control.expect("START")
        if given == "opened":
            self.join("ros")
            self.join("bulk_1")
            for body in OPENINGS:
                self.control.send(json_frame("OPEN", body))
                self.control.expect("OPENED")

    def join(self, lane: str) -> None:
        peer = self.lanes[lane] = Peer(self._address)
        ticket = self._welcome["tickets"][lane]
        peer.send(json_frame("JOIN", {"session": self.session, "ticket": ticket, "lane": lane}))
        peer.expect("JOINED")

    def fill_in(self, sent: bytes, lane: str) -> bytes:
        """A vector's bytes with the values of this session."""
        ticket = self._welcome["tickets"].get(lane, TICKET)
        for text, value in ((SESSION, self.session), (TICKET, ticket), (REQUEST, self._request)):
            sent = sent.replace(text.encode(), str(value).rjust(32).encode())
        return sent


class StreamingDevice(ScriptedDevice):
    """A session whose own thread streams battery messages and says PING until it is left."""

    def __enter__(self) -> Self:
        self.reach("streaming")
        self._is_over = threading.Event()
        self._sender = threading.Thread(target=self._stream, daemon=True)
        self._sender.start()
        return self

    def _stream(self) -> None:
        sequence = 0
        while not self._is_over.wait(0.01):
            self.control.send(frame("PING"))
            self.lanes["sensors"].send(
                frame("DATA", STRING_PAYLOAD, channel=CHANNELS[0]["id"], sequence=sequence)
            )
            sequence += 1

    def __exit__(self, *_: object) -> None:
        self._is_over.set()
        self._sender.join()
        super().__exit__()

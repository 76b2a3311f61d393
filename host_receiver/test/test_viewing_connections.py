"""Idle connections to `ml2-receiver view`, and to the receiver's own listeners."""

import errno
import http.client
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any
from urllib.parse import urlsplit

import pytest

from view_scene import ROWS, Page, serving
from waiting import LIMIT_S, await_true

pytest.importorskip("websockets", reason="websockets is not installed")

from ml2_receiver.session.acceptor import Acceptor
from ml2_receiver.transport.listener import listen
from ml2_tools.viewing import server
from ml2_tools.viewing.bounded_listener import MOST_STRANGERS

FLOOD = 400


@pytest.fixture
def page() -> Iterator[Page]:
    with serving(ROWS) as page:
        yield page


def status(page: Page) -> int:
    connection = http.client.HTTPConnection(urlsplit(page.url).netloc, timeout=LIMIT_S)
    connection.request("GET", "/")
    response = connection.getresponse()
    response.read()
    connection.close()
    return response.status


def idle(page: Page, stack: ExitStack, count: int, first: bytes = b"") -> list[socket.socket]:
    address = urlsplit(page.url)
    found = []
    for _ in range(count):
        it = stack.enter_context(socket.create_connection((address.hostname, address.port)))
        it.settimeout(LIMIT_S)
        it.sendall(first)
        found.append(it)
    return found


def is_closed(connection: socket.socket) -> bool:
    try:
        return connection.recv(1) == b""
    except ConnectionError:
        return True


@pytest.mark.parametrize("first", [b"", b"GET / HTTP/1.1\r\nHost:"])
def test_a_flood_of_idle_connections_keeps_nobody_out(page: Page, first: bytes) -> None:
    with page.browser() as before, ExitStack() as stack:
        assert before.text("hello")
        idle_ones = idle(page, stack, FLOOD, first)
        assert status(page) == 200
        with page.browser() as browser:
            assert browser.text("hello")
        assert all(is_closed(it) for it in idle_ones[: FLOOD - MOST_STRANGERS])
        before.say(show=["world_left"])
        page.source.report(ROWS)
        assert before.text("state")
    assert status(page) == 200


def test_who_says_nothing_is_disconnected_before_the_handshake(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(server, "_PATIENCE_S", 0.1)
    with serving(ROWS) as page, ExitStack() as stack:
        (connection,) = idle(page, stack, 1)
        assert is_closed(connection)


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ENFILE, errno.ECONNABORTED, errno.ENOMEM])
def test_a_failure_to_accept_is_not_the_last_attempt(
    page: Page, number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    failures = fail_to_accept(monkeypatch, number)
    assert status(page) == 200
    assert failures == [number] * 3
    assert status(page) == 200


@pytest.mark.parametrize("number", [errno.EMFILE, errno.ECONNABORTED])
def test_the_receiver_goes_on_accepting(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    failures = fail_to_accept(monkeypatch, number)
    accepted: list[int] = []

    def refuse(_: socket.socket, __: str, port: int) -> bool:
        accepted.append(port)
        return False

    acceptor = Acceptor(listen(("127.0.0.1", 0)), refuse, print)
    acceptor.thread.start()
    try:
        await_true(lambda: len(failures) == 3)
        host, _, port = acceptor.address.rpartition(":")
        with socket.create_connection((host, int(port))) as peer:
            await_true(lambda: accepted == [peer.getsockname()[1]])
    finally:
        acceptor.stop()
        acceptor.thread.join()
        acceptor.close()


def fail_to_accept(monkeypatch: pytest.MonkeyPatch, number: int) -> list[int]:
    """Makes the next three calls of accept() fail; returns a list of those that did."""
    failures: list[int] = []
    accept = socket.socket.accept

    def failing(listener: socket.socket) -> tuple[socket.socket, Any]:
        if len(failures) < 3:
            failures.append(number)
            raise OSError(number, "as the system says")
        return accept(listener)

    monkeypatch.setattr(socket.socket, "accept", failing)
    return failures


def test_idle_connections_do_not_delay_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "_PATIENCE_S", 2 * LIMIT_S)
    with ExitStack() as stack:
        with serving(ROWS) as page:
            idle(page, stack, MOST_STRANGERS // 2)
            assert status(page) == 200
            began_s = time.monotonic()
        assert time.monotonic() - began_s < LIMIT_S

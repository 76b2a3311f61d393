"""The server of `ml2-receiver view` refuses strangers, and ends wrong connections."""

import http.client
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack
from urllib.parse import urlsplit

import pytest

from viewing_browser import Browser

pytest.importorskip("rclpy", reason="rclpy is not installed")

from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from ml2_receiver.transport.listener import listen
from ml2_tools.viewing.access import Token
from ml2_tools.viewing.live_source import LiveSource
from ml2_tools.viewing.page_files import HEADERS, page_files
from ml2_tools.viewing.pairing import PagePairing
from ml2_tools.viewing.products_beside import ProductsBeside
from ml2_tools.viewing.receiver_backend import ReceiverBackend
from ml2_tools.viewing.section_forms import section_forms
from ml2_tools.viewing.server import WRONG_TOKEN, ViewServer
from ml2_tools.viewing.view import View
from waiting import LIMIT_S

pytestmark = pytest.mark.processes
TOKEN = Token()
UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
}


@pytest.fixture
def url(ros_of_children: None) -> Iterator[str]:
    """The address of a server whose receiver says nothing."""
    listener = listen(("127.0.0.1", 0))
    address = f"http://127.0.0.1:{listener.getsockname()[1]}"
    source = LiveSource("")
    view = View(source, "", with_eyes=False)
    pairing = PagePairing(view, pytest.fail)
    products = ProductsBeside(view, "")
    offered = section_forms(with_eyes=False)
    backend = ReceiverBackend(view, source.context, "/ml2_receiver", offered, pairing, products)
    server = ViewServer(listener, view, backend, TOKEN)
    yield address
    server.close()
    backend.close()
    view.close()


def get(url: str, path: str, method: str = "GET", **headers: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection(urlsplit(url).netloc, timeout=LIMIT_S)
    connection.request(method, path, headers={k.replace("_", "-"): v for k, v in headers.items()})
    response = connection.getresponse()
    response.content = response.read()  # type: ignore[attr-defined]
    connection.close()
    return response


def test_each_file_is_served_with_the_policy(url: str) -> None:
    for path, (type, content) in page_files().items():
        response = get(url, path)
        assert (response.status, response.headers["Content-Type"]) == (200, type)
        assert response.content == content  # type: ignore[attr-defined]
        assert HEADERS.items() <= dict(response.headers).items()


def test_a_busy_browser_gets_the_whole_file(url: str) -> None:
    path, content = "/three.min.js", page_files()["/three.min.js"][1]
    address = urlsplit(url)
    with socket.socket() as browser:
        # So little fits that the server waits for the browser.
        browser.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        browser.settimeout(LIMIT_S)
        browser.connect((address.hostname, address.port))
        browser.sendall(f"GET {path} HTTP/1.1\r\nHost: {address.netloc}\r\n\r\n".encode())
        # Longer than the closing of a WebSocket may take.
        time.sleep(1.5)
        response = http.client.HTTPResponse(browser)
        response.begin()
        assert response.read() == content


def test_other_paths_and_methods_find_nothing(url: str) -> None:
    for path in ("/index.html", "/../server.py", "/%2e%2e/server.py", "/main.js?a", "/favicon.ico"):
        assert get(url, path).status == 404
    assert get(url, "/", "POST").status == 405


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:80", ""])
@pytest.mark.parametrize("path", ["/", "/main.js", "/live"])
def test_a_page_under_another_name_is_refused(url: str, host: str, path: str) -> None:
    origin = {"Origin": f"http://{host}"}
    assert get(url, path, Host=host, **origin, **UPGRADE).status == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "http://localhost:1", "null", None])
def test_another_origin_is_refused(url: str, origin: str | None) -> None:
    given = None if origin is None else Origin(origin)
    with (
        pytest.raises(InvalidStatus) as refused,
        connect(f"{url.replace('http', 'ws')}/live", origin=given),
    ):
        pass
    assert refused.value.response.status_code == 403


@pytest.mark.parametrize(
    "first", ['{"token": ""}', f'{{"token": "{"A" * 43}"}}', '{"show": []}', "[", b"\xff"]
)
def test_without_the_token_the_connection_ends(url: str, first: str | bytes) -> None:
    with Browser(url, None) as browser:
        browser.connection.send(first)
        assert browser.end() == (WRONG_TOKEN, "wrong token")


def test_who_says_nothing_is_sent_away(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ml2_tools.viewing.server._PATIENCE_S", 0.1)
    with Browser(url, None) as browser:
        assert browser.end() == (1008, "no token in 0.1 s")


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("{", 1008),
        ('{"show": ["eye_nasal_left"]}', 1008),
        ('{"seen": "world_left"}', 1008),
        (b"{}", 1008),
        ("[" * 4000, 1008),
        (" " * 5000, 1009),
    ],
)
def test_an_invalid_message_ends_that_connection_only(
    url: str, message: str | bytes, code: int
) -> None:
    with Browser(url, TOKEN.text) as other, Browser(url, TOKEN.text) as browser:
        assert browser.text("hello")["images"]
        browser.connection.send(message)
        assert browser.end()[0] == code
        other.say(show=["world_left"])
        assert other.text("hello")
        with Browser(url, TOKEN.text) as third:
            assert third.text("hello")
        assert other.connection.ping().wait(LIMIT_S)


def test_a_ninth_browser_is_sent_away(url: str) -> None:
    with ExitStack() as others:
        for _ in range(8):
            others.enter_context(Browser(url, TOKEN.text)).text("hello")
        with Browser(url, TOKEN.text) as ninth:
            assert ninth.end() == (1013, "too many browsers")

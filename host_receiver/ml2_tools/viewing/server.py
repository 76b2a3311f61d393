"""The web server of `ml2-receiver view`: the page's files and one WebSocket."""

import http
import socket
import struct
import threading
from collections.abc import Mapping
from contextlib import suppress

from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.sync.server import ServerConnection, serve

from .access import Token, is_own_host, is_own_origin
from .bounded_listener import BoundedListener
from .browser_connection import BrowserConnection, close_reason
from .page_files import HEADERS, page_files
from .requests import MOST_BYTES, Backend, RequestError
from .view import View

SOCKET_PATH = "/live"
# The page says what to do about this code, by which it knows that its token is wrong.
WRONG_TOKEN = 4401
_MOST_VISITORS = 8
_CLOSE_S = 1
# On a busy machine a browser takes seconds to connect, or to read the largest file.
_PATIENCE_S = 20
_FILE_S = 20
# A browser that reads nothing of images for so long is disconnected. A struct timeval.
_SEND_TIMEOUT = struct.pack("ll", 5, 0)


class ViewServer:
    """Serves browsers until close(), each in threads of its own.

    Args:
        listener: a listening socket of the loopback interface; it becomes the server's.
    """

    def __init__(self, listener: socket.socket, view: View, backend: Backend, token: Token) -> None:
        self._view, self._backend, self._token = view, backend, token
        self._files = page_files()
        self._places = threading.BoundedSemaphore(_MOST_VISITORS)
        self._listener = BoundedListener(listener, _FILE_S)
        self._server = serve(
            self._serve,
            sock=self._listener,
            compression=None,
            process_request=self._answer,
            server_header=None,
            open_timeout=_PATIENCE_S,
            close_timeout=_CLOSE_S,
            max_size=MOST_BYTES,
        )
        self._thread = threading.Thread(target=self._server.serve_forever, name="view-server")
        self._thread.start()

    def close(self) -> None:
        """Closes all connections and ends the threads."""
        self._server.shutdown()
        self._thread.join()

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Returns the answer to a request; None opens a WebSocket."""
        hosts = request.headers.get_all("Host")
        if not is_own_host(hosts):
            return _response(http.HTTPStatus.FORBIDDEN, "expected a Host of this machine\n")
        if request.method != "GET":
            return _response(http.HTTPStatus.METHOD_NOT_ALLOWED, "expected GET\n")
        if request.path == SOCKET_PATH:
            if is_own_origin(request.headers.get_all("Origin"), hosts):
                return None
            return _response(http.HTTPStatus.FORBIDDEN, "expected the Origin of the page\n")
        if (file := self._files.get(request.path)) is None:
            return _response(http.HTTPStatus.NOT_FOUND, "not found\n")
        type, content = file
        # A response closes the connection, and is cut off when that takes too long.
        connection.close_timeout = _FILE_S
        return _response(http.HTTPStatus.OK, content, type)

    def _serve(self, connection: ServerConnection) -> None:
        connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _SEND_TIMEOUT)
        with suppress(ConnectionClosed):
            if not self._is_let_in(connection):
                return
            self._listener.trust(connection.socket)
            if not self._places.acquire(blocking=False):
                connection.close(CloseCode.TRY_AGAIN_LATER, "too many browsers")
                return
            try:
                BrowserConnection(connection, self._view, self._backend).serve()
            except RequestError as error:
                connection.close(CloseCode.POLICY_VIOLATION, close_reason(error))
            finally:
                self._places.release()

    def _is_let_in(self, connection: ServerConnection) -> bool:
        """Returns True if a browser has sent the token; else closes the connection."""
        try:
            if self._token.opens(connection.recv(timeout=_PATIENCE_S)):
                return True
        except TimeoutError:
            # The page tries again, since its token may be right.
            connection.close(CloseCode.POLICY_VIOLATION, f"no token in {_PATIENCE_S} s")
            return False
        connection.close(WRONG_TOKEN, "wrong token")
        return False


def _response(
    status: http.HTTPStatus, content: bytes | str, type: str = "text/plain; charset=utf-8"
) -> Response:
    body = content.encode() if isinstance(content, str) else content
    headers: Mapping[str, str] = {
        "Connection": "close",
        "Content-Length": str(len(body)),
        "Content-Type": type,
        **HEADERS,
    }
    return Response(status.value, status.phrase, Headers(headers), body)

"""Messages of a browser to `ml2-receiver view`: what is taken names offered streams only."""

from collections.abc import Iterator

from ml2_tools.viewing.access import Token
from ml2_tools.viewing.requests import RequestError, Seen, parse_request

_STREAMS = ("color", "world_left")
_TOKEN = Token()


def seeds() -> Iterator[bytes]:
    yield b'{"show": ["color", "world_left"]}'
    yield b'{"seen": "state"}'
    yield b'{"token": "AAAA"}'


def read(data: bytes) -> None:
    text = data.decode(errors="surrogateescape")
    for message in (data, text):
        assert not _TOKEN.opens(message)
        try:
            request = parse_request(message, _STREAMS)
        except RequestError:
            continue
        assert isinstance(request, Seen) or request.streams <= set(_STREAMS)

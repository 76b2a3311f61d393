"""Messages of a browser to `ml2-receiver view`: what is taken names only what is offered."""

from collections.abc import Iterator

from ml2_tools.viewing.access import Token
from ml2_tools.viewing.controls import SERVICES, controls
from ml2_tools.viewing.requests import Call, Change, RequestError, Show, parse_request

_STREAMS = ("color", "world_left")
_CONTROLS = controls(with_eyes=False)
_TOKEN = Token()


def seeds() -> Iterator[bytes]:
    yield b'{"show": ["color", "world_left"]}'
    yield b'{"seen": "state"}'
    yield b'{"set": "depth_center", "to": {"stream": 1, "mode": "544x480@5"}}'
    yield b'{"set": "world_left", "to": {"enabled": true, "format": "jpeg"}}'
    yield b'{"call": "stop"}'
    yield b'{"token": "AAAA"}'


def read(data: bytes) -> None:
    text = data.decode(errors="surrogateescape")
    for message in (data, text):
        assert not _TOKEN.opens(message)
        try:
            request = parse_request(message, _STREAMS, _CONTROLS)
        except RequestError:
            continue
        match request:
            case Show(streams):
                assert streams <= set(_STREAMS)
            case Change(section, values):
                allowed = _CONTROLS[section].allowed
                assert values
                assert all(value in allowed[key] for key, value in values.items())
            case Call(service):
                assert service in SERVICES

"""Messages of a browser to `ml2-receiver view`: what is taken names only what is offered."""

import math
from collections.abc import Iterator
from itertools import product

from ml2_receiver.wire.json_body import Scalar
from ml2_tools.viewing.access import Token
from ml2_tools.viewing.requests import (
    AllowedRequests,
    Call,
    Change,
    RequestError,
    Seek,
    Show,
    Speed,
    parse_request,
)
from ml2_tools.viewing.section_forms import SERVICES, SectionForm, section_forms

_STREAMS = ("color", "world_left")
_FORMS = section_forms(with_eyes=False)
_ALLOWED = AllowedRequests(_FORMS, SERVICES), AllowedRequests(length_s=20)
_TOKEN = Token()


def seeds() -> Iterator[bytes]:
    yield b'{"show": ["color", "world_left"]}'
    yield b'{"seen": "state"}'
    yield b'{"set": "depth_center", "to": {"stream": 1, "mode": "544x480@5"}}'
    yield b'{"set": "world_left", "to": {"enabled": true, "format": "jpeg"}}'
    yield b'{"set": "world_left", "to": {"quality": 80}}'
    yield b'{"set": "general", "to": {"link": "99.5"}}'
    yield b'{"call": "stop"}'
    yield b'{"pixel": "color", "at": [3, 4]}'
    yield b'{"seek": 12.5}'
    yield b'{"speed": 0.5}'
    yield b'{"play": true}'
    yield b'{"token": "AAAA"}'


def read(data: bytes) -> None:
    text = data.decode(errors="surrogateescape")
    messages: tuple[str | bytes, ...] = data, text
    for message, offer in product(messages, _ALLOWED):
        assert not _TOKEN.opens(message)
        try:
            request = parse_request(message, _STREAMS, offer)
        except RequestError:
            continue
        match request:
            case Show(streams):
                assert streams <= set(_STREAMS)
            case Seek(offset_s):
                assert 0 <= offset_s <= 20
            case Speed(rate):
                assert 0.25 <= rate <= 4
            case Change(section, values):
                assert values
                for key, value in values.items():
                    assert _is_legal(_FORMS[section], key, value), (section, key, value)
            case Call(service):
                assert service in SERVICES


def _is_legal(form: SectionForm, key: str, value: Scalar) -> bool:
    match key, value:
        case "mode", str():
            return value in [mode for _, mode in form.modes]
        case "enabled", bool():
            return True
        case "quality", int():
            return 1 <= value <= 100
        case "link", str() | int() | float():
            return value in ("auto", "fixed") or 0 < float(value) < math.inf
        case "stream" | "format", int() | str():
            return value in form.keys[key].allowed
    return False

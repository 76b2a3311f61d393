"""JSON bodies: one that is taken is the same after it was written and read again.

Names in it are short and printable.
"""

import json
from collections.abc import Iterator

from ml2_receiver.errors import ProtocolError
from ml2_receiver.topics.config_topic import ConfigText
from ml2_receiver.wire.json_body import JsonBody
from ml2_receiver.wire.messages import Hello
from ml2_receiver.wire.pairing_bodies import Paired
from vectors import HEADER_BYTES, vectors

_BODIES = sorted(JsonBody.__subclasses__(), key=lambda it: it.__name__)
_NAMES = {it.__name__.upper(): number for number, it in enumerate(_BODIES)}
# PROTOCOL.md bounds no name to more characters: that of a topic.
_MOST_CHARACTERS = 255
assert {ConfigText, Hello, Paired} <= set(_BODIES)


def seeds() -> Iterator[bytes]:
    """Yields each body's kind and bytes."""
    for case, _ in vectors("wire"):
        for frame in case["frames"]:
            name = (frame["name"] or "").replace("_", "")
            if "json" in frame and name in _NAMES:
                body = json.dumps(frame["json"], ensure_ascii=False).encode()
                yield bytes([_NAMES[name]]) + body
    for _, data in vectors("malformed", "*Hello*"):
        yield bytes([_NAMES["HELLO"]]) + data[HEADER_BYTES:]


def read(data: bytes) -> None:
    kind = _BODIES[data[0] % len(_BODIES)]
    try:
        body = kind.parse(data[1:])
    except ProtocolError:
        return
    assert kind.parse(body.to_bytes()) == body
    for key in ("name", "software", "device_id", "instance_id"):
        text = getattr(body, key, None) or ""
        assert text.isprintable(), (key, text)
        assert len(text) <= _MOST_CHARACTERS, (key, text)

"""Messages of recordings as objects, without ROS."""

from __future__ import annotations

import functools
import struct
from collections.abc import Callable
from typing import Any

from mcap.records import Schema
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap_ros2.decoder import DecoderFactory

from ml2_receiver.generated.message_definitions import DEFINITIONS

_BROKEN = (ValueError, IndexError, OverflowError, struct.error)


@functools.cache
def decoder(type: str) -> Callable[[bytes], Any]:
    """What decodes payloads of a type of the stream table, as "sensor_msgs/msg/Image".

    Attributes of what it returns are named as in ROS; a sequence of uint8 is `bytes`, which may be
    shorter than the payload claims. The type's definition is ours, never the recording's. It
    raises ValueError for a payload that is not of that type.

    Raises:
        KeyError: the table has no such type.
    """
    schema = Schema(1, DEFINITIONS[type].encode(), SchemaEncoding.ROS2, type)
    decode = DecoderFactory().decoder_for(MessageEncoding.CDR, schema)
    assert decode is not None

    def decode_checked(payload: bytes) -> Any:
        try:
            return decode(payload)
        except _BROKEN as error:
            raise ValueError(f"not a {type}: {error}") from error

    return decode_checked

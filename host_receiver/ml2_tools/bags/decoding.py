"""Decodes messages of recordings without ROS."""

import functools
import struct
from collections.abc import Callable
from typing import Any

from mcap.records import Schema
from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap_ros2.decoder import DecoderFactory

from ml2_receiver.recording.message_definitions import DEFINITIONS

_BROKEN = (ValueError, IndexError, OverflowError, struct.error)


@functools.cache
def decoder(type: str) -> Callable[[bytes], Any]:
    """Returns a function that decodes payloads of a message type.

    The decoded objects have ROS's attribute names. A sequence of uint8 is `bytes`, which may be
    shorter than the payload claims. The message definition is the receiver's own, never the
    recording's. The function raises ValueError for a payload that is not of the type.

    Args:
        type: a type in the stream table, such as "sensor_msgs/msg/Image".

    Raises:
        KeyError: the stream table does not have the type.
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

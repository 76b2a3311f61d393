"""Publishes bytes as they are."""

from collections.abc import Callable
from typing import Any

from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.publisher import Publisher
from rclpy.serialization import serialize_message

from ..errors import PublishError
from ..session.sink import Publish


def takes_bytearray(publisher: Publisher, message: Any) -> bool:
    """Tries with `message` whether this rclpy publishes a bytearray without a copy to bytes."""
    try:
        publisher.handle.publish_raw(bytearray(serialize_message(message)))
    except (AttributeError, TypeError):
        return False
    return True


def raw_publish(publisher: Publisher, is_bytearray_taken: bool) -> Publish:
    """Returns a function that publishes payloads without the copy that rclpy's publish() makes."""
    handle = publisher.handle
    publish_raw: Callable[[bytearray], None] = (
        handle.publish_raw
        if is_bytearray_taken
        else lambda payload: publisher.publish(bytes(payload))
    )

    def publish(payload: bytearray) -> None:
        try:
            with handle:
                publish_raw(payload)
        except InvalidHandle:
            pass  # the topic ended while this was under way
        except rclpy_implementation.RCLError as error:
            raise PublishError(str(error)) from error

    return publish

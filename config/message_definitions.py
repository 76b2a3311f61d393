"""The message types of the stream table, of ROS 2 Jazzy and of the packages without a wheel."""

import json
from pathlib import Path
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from ml2_receiver.table.stream_table import StreamTable

_MESSAGES = Path(__file__).parents[1] / "host_receiver/environment/messages"


def typestore() -> Any:
    """The types, as rosbags has them."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for file in _MESSAGES.glob("*/msg/*.msg"):
        type = f"{file.parts[-3]}/msg/{file.stem}"
        if type not in store.fielddefs:
            store.register(get_types_from_msg(file.read_text("utf-8"), type))
    return store


def message_definitions(table: StreamTable) -> str:
    """Lines of the definitions as a recording has them, without the comments, by type."""
    store = typestore()
    types = sorted(
        {topic.type for stream in table.streams.values() for topic in stream.topics}
        | {topic.type for topic in table.receiver_topics}
    )
    definitions = {
        type: store.generate_msgdef(type, ros_version=2)[0].rstrip().splitlines() for type in types
    }
    return json.dumps(definitions, indent=1) + "\n"

"""The message types of the stream table as a recording describes them."""

import json

from rosbags.typesys import Stores, get_typestore

from ml2_receiver.table.stream_table import StreamTable


def message_definitions(table: StreamTable) -> str:
    """Lines of the definitions as of ROS 2 Jazzy, without the comments, by type."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types = sorted(
        {topic.type for stream in table.streams.values() for topic in stream.topics}
        | {topic.type for topic in table.receiver_topics}
    )
    definitions = {
        type: store.generate_msgdef(type, ros_version=2)[0].rstrip().splitlines() for type in types
    }
    return json.dumps(definitions, indent=1) + "\n"

"""The description of a stream in generated code."""

from ml2_receiver.table.stream_table import Stream, StreamTable


def stream_summary(table: StreamTable, stream: Stream) -> str:
    """Its main topic; the stream whose topics the device names has none."""
    if not stream.topics:
        return table.sections[stream.section].doc
    main = stream.topics[0]
    return f"{main.type} on {main.name}."

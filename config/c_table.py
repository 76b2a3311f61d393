"""The ids of the stream table as a C header."""

from ml2_receiver.table import StreamTable


def c_table(table: StreamTable) -> str:
    names = [f"    ML2S_STREAM_{id.upper()} = {index}," for index, id in enumerate(table.streams)]
    return f"""// The streams of config/streams.yaml, in its order; generated from it by config/generate.py.
#pragma once

typedef enum ml2s_stream {{
{chr(10).join(names)}
    ML2S_STREAM_COUNT = {len(names)},
}} ml2s_stream;
"""

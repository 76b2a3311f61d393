"""The text of the topic `config`: the headset's answer to the configuration."""

from collections.abc import Mapping
from dataclasses import dataclass

from ..session.sink import Applied
from ..wire.json_body import JsonBody, Scalar
from ..wire.messages import StreamStatus


@dataclass(frozen=True)
class TopicEntry:
    topic: str
    type: str
    qos: str
    role: str


@dataclass(frozen=True)
class StreamEntry:
    result: str
    values: Mapping[str, Scalar] | None
    reason: str | None
    topics: list[TopicEntry]
    state: StreamStatus | None = None


@dataclass(frozen=True)
class ConfigText(JsonBody):
    headset: str
    session: str
    streams: Mapping[str, StreamEntry]
    device_id: str = ""


def config_text(applied: Applied, prefix: str) -> str:
    """Returns the answer as JSON, with the full names of topics."""
    topics: dict[str, list[TopicEntry]] = {stream: [] for stream in applied.streams}
    for topic in applied.topics:
        entry = TopicEntry(topic.full_name(prefix), topic.type, topic.qos, topic.role)
        topics[topic.stream].append(entry)
    streams = {
        stream: StreamEntry(
            answer.result, answer.values, answer.reason, topics[stream], applied.states.get(stream)
        )
        for stream, answer in applied.streams.items()
    }
    text = ConfigText(applied.headset, applied.session, streams, applied.device_id)
    return text.to_bytes().decode()

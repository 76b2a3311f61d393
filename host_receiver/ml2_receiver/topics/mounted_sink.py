"""Publishes how the headset's inertial units are mounted, which the headset does not know."""

from collections.abc import Sequence
from dataclasses import replace

from ..configuration.mounts import Mounts
from ..errors import PublishError
from ..session.report import Report
from ..session.sink import Applied, Publish, Sink, refuse
from ..table.reader import load_table
from ..table.stream_table import Topic
from .plain_messages import StaticTransform, append_transforms

_ROLE = "tf_static"


class MountedSink:
    """A Sink in front of another one that adds the mounts of the headset's units to /tf_static.

    If the headset has that topic, its messages get them too: a subscriber that comes late gets one
    message only. Threads are as for Sink.

    Args:
        mounts: by device id and stream.
        frame_prefix: the prefix of the headset's frame ids.
    """

    def __init__(self, sink: Sink, mounts: Mounts, frame_prefix: str) -> None:
        self._sink, self._mounts, self._frame_prefix = sink, mounts, frame_prefix
        self._transforms: Sequence[StaticTransform] = ()
        self._session = ""
        (self._topic,) = (it for it in load_table().streams["tf"].topics if it.role == _ROLE)

    def open(self, topic: Topic) -> Publish:
        publish = self._sink.open(topic)
        if topic.role != _ROLE:
            return publish

        def publish_with_mounts(payload: bytearray) -> None:
            transforms = self._transforms
            publish(append_transforms(payload, transforms) if transforms else payload)

        return publish_with_mounts

    def configured(self, applied: Applied) -> None:
        self._transforms = self._transforms_of(applied.device_id)
        of_headset = any(it.role == _ROLE for it in applied.topics)
        if not self._transforms or of_headset or self._topic.stream not in applied.streams:
            self._session = ""
            self._sink.configured(applied)
            return
        if is_new := self._session != applied.session:
            publish = self._opened()  # before the answer: topics that it lacks end
        self._sink.configured(replace(applied, topics=[*applied.topics, self._topic]))
        self._session = applied.session
        if is_new:
            try:
                publish(append_transforms(b"", self._transforms))
            except PublishError as error:
                self._sink.event(f"{self._topic.name}: {error}")

    def _opened(self) -> Publish:
        try:
            return self._sink.open(self._topic)
        except PublishError as error:
            self._sink.event(str(error))
            return refuse

    def _transforms_of(self, device_id: str) -> list[StaticTransform]:
        table, prefix = load_table(), self._frame_prefix
        found = []
        for stream, mount in self._mounts.get(device_id, {}).items():
            x, y, z = mount.translation_m
            qx, qy, qz, qw = mount.rotation
            frame = prefix + table.streams[stream].topics[0].frame
            head = prefix + table.head_frame
            found.append(StaticTransform(head, frame, (x, y, z), (qx, qy, qz, qw)))
        return found

    def event(self, text: str) -> None:
        self._sink.event(text)

    def session_ended(self, report: Report) -> None:
        self._session = ""
        self._sink.session_ended(report)

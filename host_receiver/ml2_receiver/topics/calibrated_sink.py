"""Replaces the device's calibration with the user's."""

import struct
from collections.abc import Iterator, Mapping

from ..configuration.calibration import Calibration
from ..errors import PublishError
from ..session.report import Report
from ..session.sink import Applied, Publish, Sink
from ..table.stream_table import Topic
from ..wire.frame import CDR_ENCAPSULATION

_TIME_BYTES = 8
_UINT32 = struct.Struct("<I")
_SIZE = struct.Struct("<II")


class CalibratedSink:
    """A Sink in front of another one that replaces the values of some streams' camera_info.

    The header of the message and its sequence number stay; nothing else of the payload is decoded.
    If the calibration is for another resolution, the device's values stay, and an event says so
    once.
    Threads are as for Sink; any thread may call use().

    Args:
        calibrations: calibrations by stream.
    """

    def __init__(self, sink: Sink, calibrations: Mapping[str, Calibration]) -> None:
        self._sink = sink
        self._told: dict[str, str] = {}
        self.use(calibrations)

    def use(self, calibrations: Mapping[str, Calibration]) -> None:
        """Uses these calibrations from the next message on."""
        self._overrides = {stream: CameraInfoOverride(it) for stream, it in calibrations.items()}

    def open(self, topic: Topic) -> Publish:
        publish = self._sink.open(topic)
        if topic.role != "camera_info":
            return publish

        def publish_calibrated(payload: bytearray) -> None:
            override = self._overrides.get(topic.stream)
            publish(payload if override is None else override.apply(payload))

        return publish_calibrated

    def configured(self, applied: Applied) -> None:
        self._sink.configured(applied)
        before, self._told = self._told, dict(self._mismatches(applied))
        for stream, text in self._told.items():
            if text != before.get(stream):
                self._sink.event(text)

    def _mismatches(self, applied: Applied) -> Iterator[tuple[str, str]]:
        """Yields each stream whose images have another size than its calibration, and the event."""
        for stream, override in self._overrides.items():
            answer = applied.streams.get(stream)
            if answer is None or answer.values is None or answer.result == "refused":
                continue
            values = answer.values
            found = values.get("resolution_width"), values.get("resolution_height")
            if found != override.size:
                yield (
                    stream,
                    f"{stream}: the calibration is for {override.size[0]}x{override.size[1]}, but"
                    f" the headset sends {found[0]!r}x{found[1]!r}:"
                    " its own camera_info is published",
                )

    def event(self, text: str) -> None:
        self._sink.event(text)

    def session_ended(self, report: Report) -> None:
        self._sink.session_ended(report)


class CameraInfoOverride:
    """Replaces everything after the header in CDR payloads of sensor_msgs/CameraInfo.

    Attributes:
        size: width and height of the calibration's images, in pixels.
    """

    def __init__(self, calibration: Calibration) -> None:
        self.size = calibration.width, calibration.height
        self._calibration = calibration
        self._rest: dict[int, bytes] = {}

    def apply(self, payload: bytearray) -> bytearray:
        """Returns a new payload, or the same one if the images have another size.

        Raises:
            PublishError: `payload` is too short for a CameraInfo.
        """
        try:
            start = _after_header(payload)
            height, width = _SIZE.unpack_from(payload, start)
        except struct.error as error:
            raise PublishError(f"camera_info of {len(payload)} bytes") from error
        if (width, height) != self.size:
            return payload
        rest = self._rest.get(start)
        if rest is None:
            rest = _rest(self._calibration, start)
            self._rest = {start: rest}
        return payload[:start] + rest


def _after_header(payload: bytearray) -> int:
    """Returns the offset of height: a header is a time and a string."""
    text = len(CDR_ENCAPSULATION) + _TIME_BYTES
    (length,) = _UINT32.unpack_from(payload, text)
    return _aligned(text + _UINT32.size + int(length), 4)


def _aligned(position: int, size: int) -> int:
    """Aligns an offset as CDR does, from the end of the encapsulation."""
    return position + (len(CDR_ENCAPSULATION) - position) % size


def _rest(calibration: Calibration, start: int) -> bytes:
    """Encodes height to roi.do_rectify, for a message whose height is at offset `start`."""
    model = calibration.model.encode() + b"\0"
    rest = _SIZE.pack(calibration.height, calibration.width) + _UINT32.pack(len(model)) + model
    rest = _padded(rest, start, 4) + _UINT32.pack(len(calibration.d))
    doubles = (*calibration.d, *calibration.k, *calibration.r, *calibration.p)
    rest = _padded(rest, start, 8) + struct.pack(f"<{len(doubles)}d", *doubles)
    no_binning_whole_image = bytes(6 * _UINT32.size + 1)
    return rest + no_binning_whole_image


def _padded(rest: bytes, start: int, size: int) -> bytes:
    end = start + len(rest)
    return rest + bytes(_aligned(end, size) - end)

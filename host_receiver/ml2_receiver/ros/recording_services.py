"""Records beside all else, when a service asks for it."""

import time
from pathlib import Path

from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from std_srvs.srv import Trigger

from ..errors import RecordingError
from ..recording.bag_folder import make_folder
from ..recording.mcap_file import COMPRESSIONS
from ..recording.options import RecordingOptions
from ..recording.recorder import Progress
from ..recording.recording import Recording, summary
from ..session.report import Report
from ..table.reader import load_table
from ..topics.control import ReceiverControl
from ..topics.diagnostics import Level, Row
from ..topics.fan_out import FanOut
from .outcome import Outcome, trigger
from .parameters import ParameterNode

_OTHER_FOLDER = "Set the parameter record.folder to another folder."
_NAMED_BY_TIME = "ml2_%Y-%m-%d_%H-%M-%S"
_PARAMETERS: dict[str, tuple[str | int, str]] = {
    "folder": ("", "of the next recording; empty is one named by the time, where run was started"),
    "topics": ("", "names or patterns of topics with spaces between; empty is all"),
    "compression": ("none", f"of chunks, one of {', '.join(COMPRESSIONS)}"),
    "split_size_mb": (0, "begin another file when one has so many MB; 0 is never"),
    "split_duration_s": (0, "begin another file after so many seconds; 0 is never"),
}


class RecordingServices:
    """~/start_recording and ~/stop_recording; parameters record.* say where to and what.

    Used by the node's executor, but rows().
    """

    def __init__(
        self, node: ParameterNode, control: ReceiverControl, prefix: str, sinks: FanOut
    ) -> None:
        self._node, self._control, self._prefix, self._sinks = node, control, prefix, sinks
        self._recording: Recording | None = None
        self._is_over = False
        for name, (default, description) in _PARAMETERS.items():
            descriptor = ParameterDescriptor(description=description)
            if isinstance(default, int):
                descriptor.integer_range = [IntegerRange(from_value=0, to_value=1 << 31, step=1)]
            node.declare_parameter(f"record.{name}", default, descriptor)
        node.create_service(Trigger, "~/start_recording", trigger(self._start))
        node.create_service(Trigger, "~/stop_recording", trigger(self._stop))

    @property
    def is_on(self) -> bool:
        """True while messages are recorded; any thread may read it."""
        recording = self._recording
        return recording is not None and not self._is_over and recording.failure is None

    def close(self) -> None:
        """Ends the recording there may be."""
        if self._recording is not None:
            self._recording.end()

    def rows(self, report: Report | None) -> list[Row]:
        """The row of /diagnostics: the recording there is, or the last one."""
        recording = self._recording
        if recording is None:
            return []
        state = "ended" if self._is_over else "recording"
        state = "failed" if recording.failure is not None else state
        return [_row(state, recording, recording.progress(None if self._is_over else report))]

    def _start(self) -> Outcome:
        if self._recording is not None:
            if self.is_on:
                return False, f"a recording into {self._recording.folder} is on: ~/stop_recording"
            self._recording.end()
        values = {name: self._node.get_parameter(f"record.{name}").value for name in _PARAMETERS}
        if values["compression"] not in COMPRESSIONS:
            known, found = ", ".join(COMPRESSIONS), values["compression"]
            raise RecordingError(f"record.compression: expected one of {known}, found {found!r}")
        folder = Path(values["folder"] or time.strftime(_NAMED_BY_TIME)).absolute()
        make_folder(folder, is_overwriting=False, remedy=_OTHER_FOLDER)
        options = RecordingOptions(
            values["compression"],
            tuple(values["topics"].split()),
            values["split_size_mb"],
            values["split_duration_s"],
        )
        self._recording = Recording(
            folder, options, self._prefix, self._sinks, self._failed, self._control.report()
        )
        self._is_over = False
        self._need(True)
        self._sinks.event(f"recording into {folder}")
        return True, f"recording into {folder}"

    def _stop(self) -> Outcome:
        recording = self._recording
        if recording is None or self._is_over:
            return False, "no recording is on"
        recording.end()
        progress = recording.progress(self._control.report())
        self._is_over = True
        self._need(False)
        words = f"recorded into {recording.folder}: {summary(progress)}"
        if recording.failure is not None:
            return False, f"{words}; it ended early: {recording.failure}"
        self._sinks.event(words)
        return True, words

    def _need(self, everything: bool) -> None:
        self._control.demand("recording", dict.fromkeys(load_table().streams, everything))

    def _failed(self, reason: str) -> None:
        self._need(False)
        self._sinks.event(f"the recording has ended: {reason}")


def _row(state: str, recording: Recording, progress: Progress) -> Row:
    values = {
        "state": state,
        "folder": str(recording.folder),
        "duration_s": f"{progress.duration_s:.3f}",
        "file_bytes": str(progress.file_bytes),
        "messages": str(progress.messages),
        "dropped": str(sum(progress.dropped.values())),
        "lost": str(sum(progress.lost.values())),
    }
    values |= {f"dropped.{topic}": str(count) for topic, count in progress.dropped.items()}
    values |= {f"lost.{topic}": str(count) for topic, count in progress.lost.items()}
    message = f"{state}, {summary(progress)}"
    if recording.failure is not None:
        return Row("recording", Level.ERROR, f"{message}: {recording.failure}", values)
    level = Level.WARN if progress.dropped or progress.lost else Level.OK
    return Row("recording", level, message, values)

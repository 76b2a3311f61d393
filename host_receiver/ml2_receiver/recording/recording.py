"""One recording beside all else that happens to a headset's topics."""

from collections.abc import Callable, Mapping
from pathlib import Path

from ..session.report import Report
from ..table.reader import load_table
from ..topics.fan_out import FanOut
from .bag_folder import cannot_record
from .bag_writer import BagWriter
from .options import RecordingOptions
from .recorder import Progress, Recorder


class Recording:
    """Records what `sinks` is told, from now until end(), which must be called.

    Args:
        folder: exists and is empty.
        prefix: of the relative topics.
        on_failure: called once, by a thread, when the disk fails, with what it said.
        before: the session there is already.

    Raises:
        RecordingError: it cannot be written to.
    """

    def __init__(
        self,
        folder: Path,
        options: RecordingOptions,
        prefix: str,
        sinks: FanOut,
        on_failure: Callable[[str], None],
        before: Report | None = None,
    ) -> None:
        self.folder, self._sinks, self._is_over = folder, sinks, False
        try:
            writer = BagWriter(
                folder, options.compression, options.split_bytes, options.split_duration_ns
            )
        except OSError as error:
            raise cannot_record(folder, error) from error
        patterns = options.topics
        self._recorder = Recorder(
            writer, load_table(), prefix, on_failure, patterns=patterns, before=before
        )
        sinks.add(self._recorder)

    @property
    def failure(self) -> str | None:
        """The reason of an early end, or None."""
        return self._recorder.failure

    def progress(self, report: Report | None) -> Progress:
        """Returns the present progress; `report` is that of the current session."""
        self._recorder.hear(report)
        return self._recorder.progress

    def end(self) -> None:
        """Writes what is left; may be called again."""
        if not self._is_over:
            self._is_over = True
            self._sinks.remove(self._recorder)
            self._recorder.close()


def summary(progress: Progress) -> str:
    """A summary of one line."""
    return (
        f"{progress.duration_s:.1f} s, {progress.file_bytes / 1e6:.1f} MB,"
        f" {progress.messages} messages, {_total(progress.dropped)} dropped,"
        f" {_total(progress.lost)} lost before the receiver"
    )


def losses(progress: Progress) -> list[str]:
    """A line for each topic of which something is missing."""
    return [
        f"{topic}: {progress.dropped.get(topic, 0)} dropped,"
        f" {progress.lost.get(topic, 0)} lost before the receiver"
        for topic in sorted({*progress.dropped, *progress.lost})
    ]


def _total(counts: Mapping[str, int]) -> int:
    return sum(counts.values())

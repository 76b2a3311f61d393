"""Opens files whose records say how long they are."""

import io
from pathlib import Path

from ml2_receiver.configuration import whole_file
from ml2_receiver.errors import RecordingError

# The largest record that is read, and the largest chunk after unpacking. Chunks of `ml2-receiver
# record` have 4 MiB and the rest of a message; those of other programs may have 100 MB.
MAX_RECORD_BYTES = 256 * 1024 * 1024


class BoundedFile(io.BufferedReader):
    """A file that refuses to read more bytes at once than the largest record has."""

    def read(self, size: int | None = -1, /) -> bytes:
        if size is None or not 0 <= size <= MAX_RECORD_BYTES:
            raise ValueError(f"a record has {size} B, expected at most {MAX_RECORD_BYTES}")
        return super().read(size)


def open_file(path: Path) -> BoundedFile:
    """Opens a file of a recording.

    Raises:
        RecordingError: it cannot be read.
    """
    try:
        return BoundedFile(whole_file.open_file(path).detach())
    except OSError as error:
        raise RecordingError(f"cannot read {path}: {error.strerror}") from error

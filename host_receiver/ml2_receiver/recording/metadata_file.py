"""metadata.yaml in the folder of a recording."""

import threading
from pathlib import Path
from queue import SimpleQueue

from ..private_files import write_private_file
from .bag_folder import METADATA


class MetadataFile:
    """The file metadata.yaml, complete at any moment; only its owner can read it.

    close() must be called.

    A separate thread writes, because replacing a file on a busy disk may take a second, and the
    messages of that second would wait in memory.

    Args:
        text: the first content.

    Raises:
        OSError: the file cannot be written.
    """

    def __init__(self, folder: Path, text: str) -> None:
        self._folder = folder
        self._texts: SimpleQueue[str | None] = SimpleQueue()
        self._error: OSError | None = None
        self._replace(text)
        self._thread = threading.Thread(target=self._run, name="metadata", daemon=True)
        self._thread.start()

    def replace(self, text: str) -> None:
        """Replaces the content soon, without waiting for the disk.

        Raises:
            OSError: an earlier content could not be written.
        """
        if self._error is not None:
            raise self._error
        self._texts.put(text)

    def close(self, text: str) -> None:
        """Replaces the content for the last time, and waits for the disk.

        Raises:
            OSError: the file cannot be written.
        """
        self._texts.put(None)
        self._thread.join()
        self._replace(text)

    def _run(self) -> None:
        while (text := self._texts.get()) is not None:
            try:
                self._replace(text)
            except OSError as error:
                self._error = error

    def _replace(self, text: str) -> None:
        draft = self._folder / f"{METADATA}.draft"
        write_private_file(draft, text.encode())
        draft.replace(self._folder / METADATA)

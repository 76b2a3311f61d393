"""Pairs a headset while the page shows a QR code."""

import threading
from collections.abc import Callable
from typing import Any

import segno

from ml2_receiver.errors import ReceiverError
from ml2_receiver.json_text import json_text
from ml2_receiver.pairing.open_pairing import OpenPairing

from .requests import Newest
from .view import View

_POLL_S = 0.2


class PagePairing:
    """At most one pairing at a time, in a thread of its own. Thread-safe.

    Args:
        view: is notified of news, by `changed`; without its browsers no pairing goes on.
        listen: begins to listen for a device; may raise ReceiverError.
    """

    def __init__(self, view: View, listen: Callable[[], OpenPairing]) -> None:
        self._view, self._listen = view, listen
        self._newest: Newest = 0, ""
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()

    @property
    def newest(self) -> Newest:
        """The number of the newest message, from 1, and the message; 0 before the first.

        While a device is waited for, it has the URI, the modules of its QR code, the time left, and
        this machine's other addresses.
        """
        return self._newest

    def begin(self) -> None:
        """Begins a pairing, unless one goes on.

        Raises:
            ReceiverError: this machine cannot listen, or its keys cannot be read.
        """
        with self._lock:
            if self._thread is not None and self._thread.is_alive():
                return
            pairing = self._listen()
            self._stopping.clear()
            self._thread = threading.Thread(target=self._run, args=[pairing], name="view-pairing")
            self._thread.start()

    def end(self) -> None:
        """Ends the pairing that goes on."""
        with self._lock:
            self._stopping.set()
            if self._thread is not None:
                self._thread.join()

    def _run(self, pairing: OpenPairing) -> None:
        uri, others = str(pairing.uris[0]), [it.host for it in pairing.uris[1:]]
        code = segno.make_qr(uri, error="m")
        modules = ["".join(map(str, row)) for row in code.matrix_iter(border=4)]
        self._tell(uri=uri, others=others, modules=modules, left_s=pairing.left_s)
        device, text = None, ""
        try:
            while device is None and not self._stopping.is_set() and self._view.is_watched:
                device = pairing.wait(_POLL_S)
        except ReceiverError as error:
            text = error.in_one_line()
        except Exception as error:  # the page must not wait for ever
            self._view.faults.add("a pairing", error)
            text = f"internal error: {error!r}"
        finally:
            pairing.close()
        if device is not None:
            text = f"paired with {device.name}"
        self._tell(is_done=device is not None, text=text)

    def _tell(self, **news: Any) -> None:
        with self._view.changed:
            message = json_text({"type": "pairing", **news})
            self._newest = self._newest[0] + 1, message
            self._view.changed.notify_all()

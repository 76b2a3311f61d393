"""Changes a running receiver for browsers, through its parameters and services."""

import queue
import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rclpy.context import Context

from ml2_receiver.errors import ReceiverError, RosError
from ml2_receiver.json_text import json_text
from ml2_receiver.wire.json_body import Scalar

from ..live.receiver_client import ReceiverClient
from .pairing import PagePairing
from .products_beside import PRODUCTS, ProductsBeside
from .requests import AllowedRequests, BackendRequest, Call, Change, Newest, Outcome, Pair
from .section_forms import SERVICES, SectionForm
from .view import View

_PERIOD_S = 1.0
_PATIENCE_S = 5.0


class ReceiverBackend:
    """Carries out requests at a running receiver, one after another. Thread-safe.

    A thread of its own waits for the receiver. While a browser is connected, it reads the values in
    force each second, because other programs change them, too.

    Args:
        view: is notified of new values, by `changed`.
        context: the context for a node of its own.
        receiver: the full name of the receiver's node.
        forms: the forms by section.
        pairing: pairs headsets with the receiver; close() ends it.
        products: runs `products` beside the page; close() ends it.
    """

    def __init__(
        self,
        view: View,
        context: Context,
        receiver: str,
        forms: Mapping[str, SectionForm],
        pairing: PagePairing,
        products: ProductsBeside,
    ) -> None:
        self.allowed = AllowedRequests(forms, SERVICES | PRODUCTS, has_pairing=True)
        self._view, self._pairing, self._products = view, pairing, products
        self._client = ReceiverClient(context, receiver, _PATIENCE_S, SERVICES)
        self._settings: tuple[int, str] = 0, ""
        self._is_over = False
        self._tasks: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="view-backend")
        self._thread.start()

    def close(self) -> None:
        """Ends the thread, after the request that is being carried out; others are dropped."""
        self._is_over = True
        self._tasks.put(_nothing)
        self._thread.join()
        self._client.close()
        self._pairing.end()
        self._products.end()

    def described(self) -> dict[str, Any]:
        return {"controls": [it.described() for it in self.allowed.forms.values()]}

    def sources(self) -> Iterable[tuple[str, Callable[[], Newest]]]:
        return [
            ("settings", lambda: self._settings),
            ("pairing", lambda: self._pairing.newest),
            ("products", lambda: self._products.newest),
        ]

    def submit(self, request: BackendRequest, answered: Callable[[Outcome], None]) -> None:
        """Carries out a request later; calls `answered` in the thread of this object."""
        assert isinstance(request, Change | Call | Pair), request

        def carry_out() -> None:
            answer = self._answer(request)
            # The page shows the values in force when it gets the answer.
            self._products.look()
            self._read_settings()
            answered(answer)

        self._tasks.put(carry_out)

    def _run(self) -> None:
        while not self._is_over:
            try:
                self._tasks.get(timeout=_PERIOD_S)()
            except queue.Empty:
                self._products.look()
                if self._view.is_watched:
                    self._read_settings()

    def _answer(self, request: Change | Call | Pair) -> Outcome:
        if isinstance(request, Pair):
            return self._pair(request)
        to = request.service if isinstance(request, Call) else request.section
        try:
            if to in PRODUCTS:
                self._switch_products(to)
                return Outcome(to, True, "")
            if isinstance(request, Call):
                return Outcome(to, *self._client.call(request.service, request.keys))
            values = {f"{to}.{key}": value for key, value in request.values.items()}
            return Outcome(to, *self._client.set(values))
        except ReceiverError as error:
            return Outcome(to, False, str(error))
        except Exception as error:  # the next request may be another one
            self._view.faults.add(f"a request for {to}", error)
            return Outcome(to, False, f"internal error: {error!r}")

    def _switch_products(self, to: str) -> None:
        if to == "start_products":
            self._products.begin()
        else:
            self._products.end()

    def _pair(self, request: Pair) -> Outcome:
        try:
            if request.is_wanted:
                self._pairing.begin()
            else:
                self._pairing.end()
        except ReceiverError as error:
            return Outcome("pair", False, error.in_one_line())
        return Outcome("pair", True, "")

    def _read_settings(self) -> None:
        names = [name for form in self.allowed.forms.values() for name in form.parameters()]
        try:
            values = self._client.get(names)
        except RosError:
            return  # the page says that the receiver does not report
        except Exception as error:  # of what a node answers that has the receiver's name
            self._view.faults.add("the receiver's parameters", error)
            return
        sections: dict[str, dict[str, Scalar]] = {section: {} for section in self.allowed.forms}
        for name, value in values.items():
            section, _, key = name.partition(".")
            sections[section][key] = value
        message = json_text({"type": "settings", "sections": sections})
        if values and message != self._settings[1]:
            with self._view.changed:
                self._settings = self._settings[0] + 1, message
                self._view.changed.notify_all()


def _nothing() -> None:
    return

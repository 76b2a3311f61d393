"""Handles unexpected exceptions of callbacks: logs them, and shows them in /diagnostics."""

import traceback
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult

from ..printable import printable
from ..topics.diagnostics import Level, Row

type ServiceCallback = Callable[[Any, Any], Any]

# An error may quote what another node has sent.
_MOST_WORDS, _MOST_TRACE = 500, 20_000


class Failures:
    """Exceptions that are defects of the receiver: each ends its callback, and nothing else.

    Used by the executor's thread.

    Args:
        log: takes a text with the traceback; not called again while the same exception repeats.
    """

    def __init__(self, log: Callable[[str], None]) -> None:
        self._log = log
        self._count = 0
        self._last = ""

    def add(self, error: Exception) -> str:
        """Counts and logs it; returns what to tell the caller."""
        self._count += 1
        words = printable(f"{type(error).__name__}: {error}", _MOST_WORDS)
        if words != self._last:
            self._last = words
            trace = "".join(traceback.format_exception(error))
            self._log(printable(trace, _MOST_TRACE, has_lines=True))
        return f"the receiver failed: {words}; its log says where. Please report this"

    def answering(self, answer: ServiceCallback) -> ServiceCallback:
        """The callback of a service, which answers that it failed where it would raise."""

        def respond(request: Any, response: Any) -> Any:
            try:
                return answer(request, response)
            except Exception as error:
                return _failed(request, response, self.add(error))

        return respond

    def rows(self) -> list[Row]:
        """The row of /diagnostics, once there is something to say."""
        if not self._count:
            return []
        message = f"callbacks that failed: {self._count}, the last with {self._last}"
        return [Row("callbacks", Level.ERROR, message, {"failures": str(self._count)})]


def _failed(request: Any, response: Any, words: str) -> Any:
    """The response, as far as its type can say so."""
    if hasattr(response, "success"):
        response.success = False
        setattr(response, "message" if hasattr(response, "message") else "status_message", words)
    elif hasattr(response, "results"):  # of set_parameters: one of each parameter
        refused = SetParametersResult(successful=False, reason=words)
        response.results += [refused] * (len(request.parameters) - len(response.results))
    elif isinstance(getattr(response, "result", None), SetParametersResult):
        response.result = SetParametersResult(successful=False, reason=words)
    return response

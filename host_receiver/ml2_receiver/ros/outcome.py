"""Answers of services of the type std_srvs/Trigger."""

from collections.abc import Callable
from typing import Any

from std_srvs.srv import Trigger

from ..errors import ReceiverError

# True if the action succeeded, and a message about it.
type Outcome = tuple[bool, str]


def trigger(act: Callable[[], Outcome]) -> Callable[[Any, Any], Any]:
    """Returns a callback that answers with the outcome, or with the error of `act`."""

    def respond(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            response.success, response.message = act()
        except ReceiverError as error:
            response.success, response.message = False, error.in_one_line()
        return response

    return respond

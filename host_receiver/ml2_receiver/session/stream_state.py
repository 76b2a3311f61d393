"""The states of enabled streams, and their descriptions for the user."""

from collections.abc import Mapping

from ..wire.messages import StreamAnswer, StreamStatus

_RUNNING = StreamStatus("running")


def stream_states(
    answers: Mapping[str, StreamAnswer], reported: Mapping[str, StreamStatus]
) -> dict[str, StreamStatus]:
    """Returns the state of each stream of `answers`: the reported one, or else the answered one."""
    return {id: reported.get(id) or _answered_state(answer) for id, answer in answers.items()}


def _answered_state(answer: StreamAnswer) -> StreamStatus:
    return StreamStatus("refused", answer.reason) if answer.result == "refused" else _RUNNING


def in_words(stream: str, status: StreamStatus) -> str:
    """Returns the state, the reason, and what to do if that is known."""
    words = state_and_reason(status)
    return f"{words}; {fix}" if (fix := grant(stream, status.permission)) else words


def state_and_reason(status: StreamStatus) -> str:
    """Returns the state, and the reason if that is known."""
    return status.state if not status.reason else f"{status.state}: {status.reason}"


def grant(stream: str, permission: str | None) -> str:
    """Returns how to grant a missing permission; empty if `permission` is None."""
    if permission is None:
        return ""
    return f"{permission} is missing: run `ml2-receiver headset grant {stream}`"


def changes_in_words(
    before: Mapping[str, StreamStatus], now: Mapping[str, StreamStatus]
) -> list[str]:
    """Returns one line per new state, with all streams that changed to it."""
    alike: dict[StreamStatus, list[str]] = {}
    for id, status in now.items():
        if status != before.get(id, _RUNNING):
            alike.setdefault(status, []).append(id)
    return [
        f"{', '.join(ids)}: "
        + ("running again" if status.state == "running" else in_words(" ".join(ids), status))
        for status, ids in alike.items()
    ]

"""What is said of a stream that does not run, though it is enabled."""

from collections.abc import Mapping

from ..wire.messages import StreamAnswer, StreamStatus

_RUNNING = StreamStatus("running")


def stream_states(
    answers: Mapping[str, StreamAnswer], told: Mapping[str, StreamStatus]
) -> dict[str, StreamStatus]:
    """By stream, how each of the `answers` stands by what the headset has `told` since."""
    return {id: told.get(id) or _answered(answer) for id, answer in answers.items()}


def _answered(answer: StreamAnswer) -> StreamStatus:
    return StreamStatus("refused", answer.reason) if answer.result == "refused" else _RUNNING


def in_words(stream: str, status: StreamStatus) -> str:
    """The state, why, and what to do where that is known."""
    words = state_and_reason(status)
    return f"{words}; {fix}" if (fix := grant(stream, status.permission)) else words


def state_and_reason(status: StreamStatus) -> str:
    """The state, and why where that is known."""
    return status.state if not status.reason else f"{status.state}: {status.reason}"


def grant(stream: str, permission: str | None) -> str:
    """How the user grants what is missing; empty when it is no permission."""
    if permission is None:
        return ""
    return f"{permission} is missing: run `ml2-receiver headset grant {stream}`"


def news(before: Mapping[str, StreamStatus], now: Mapping[str, StreamStatus]) -> list[str]:
    """What a user wants to know of a change, a line for all streams that stand alike."""
    alike: dict[StreamStatus, list[str]] = {}
    for id, status in now.items():
        if status != before.get(id, _RUNNING):
            alike.setdefault(status, []).append(id)
    return [
        f"{', '.join(ids)}: "
        + ("running again" if status.state == "running" else in_words(" ".join(ids), status))
        for status, ids in alike.items()
    ]

"""The states of enabled streams, and their descriptions for the user."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from ..wire.messages import StreamAnswer, StreamStatus

_RUNNING = StreamStatus("running")


@dataclass(frozen=True)
class Judgement:
    """The receiver's judgement of a stream.

    `state` is "running" only if messages arrive as expected, "silent" if none arrives and the
    headset gives no reason, and "paused" if the receiver does not ask for the stream at present.
    Otherwise the headset reported it: "waiting", "available", "refused" or "failed". Before the
    first message a stream is "waiting", too. `permission` is the missing Android permission.
    """

    state: str
    reason: str | None = None
    permission: str | None = None

    @classmethod
    def parse(cls, text: str, permission: str | None) -> Self:
        """Returns the judgement whose `text` is given."""
        state, _, reason = text.partition(": ")
        return cls(state, reason or None, permission)

    @property
    def is_wrong(self) -> bool:
        """True if the stream should deliver and does not."""
        return self.state not in ("running", "paused")

    @property
    def text(self) -> str:
        """The state, and the reason if that is known."""
        return self.state if not self.reason else f"{self.state}: {self.reason}"


def stream_states(
    answers: Mapping[str, StreamAnswer], reported: Mapping[str, StreamStatus]
) -> dict[str, StreamStatus]:
    """Returns the state of each stream of `answers`: the reported one, or else the answered one."""
    return {id: reported.get(id) or _answered_state(answer) for id, answer in answers.items()}


def _answered_state(answer: StreamAnswer) -> StreamStatus:
    return StreamStatus("refused", answer.reason) if answer.result == "refused" else _RUNNING


def judged(status: StreamStatus) -> Judgement:
    """Returns the headset's own judgement of a stream."""
    return Judgement(status.state, status.reason, status.permission)


def in_words(stream: str, judgement: Judgement) -> str:
    """Returns the state, the reason, and what to do if that is known."""
    fix = grant(stream, judgement.permission)
    return f"{judgement.text}; {fix}" if fix else judgement.text


def grant(stream: str, permission: str | None) -> str:
    """Returns how to grant a missing permission; empty if `permission` is None."""
    if permission is None:
        return ""
    return f"{permission} is missing: run `ml2-receiver headset grant {stream}`"


def changes_in_words(
    before: Mapping[str, StreamStatus], now: Mapping[str, StreamStatus]
) -> list[str]:
    """Returns one line per new state, with all streams that changed to it.

    A lowered quality or rate is no state; the headset's event reports it.
    """
    alike: dict[Judgement, list[str]] = {}
    for id, status in now.items():
        judgement = judged(status)
        if judgement != judged(before.get(id, _RUNNING)):
            alike.setdefault(judgement, []).append(id)
    return [
        f"{', '.join(ids)}: "
        + ("running again" if it.state == "running" else in_words(" ".join(ids), it))
        for it, ids in alike.items()
    ]

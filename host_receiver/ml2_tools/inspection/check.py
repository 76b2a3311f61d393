"""The result of checking one property of a recording's topic."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

type Verdict = Literal["ok", "hint", "wrong"]
type Figure = int | float | str | list[int] | list[float]

VERDICTS: tuple[Verdict, ...] = ("ok", "hint", "wrong")


@dataclass(frozen=True)
class Check:
    """One property of one topic.

    Attributes:
        topic: the absolute name; for a transform, `PARENT -> CHILD`.
        check: "messages", "rate", "gaps", "jitter", "stamps", "pairs", "transforms" or "latency".
        verdict: "wrong" is a fault for every use of the recording, "hint" for some uses.
        found: the result in one sentence.
        figures: the numbers behind the sentence, with units in their names.
    """

    topic: str
    check: str
    verdict: Verdict
    found: str
    figures: Mapping[str, Figure] = field(default_factory=dict)


def verdict_on_share(count: int, total: int, limit: float) -> Verdict:
    """Returns "ok" if `count` is 0, "hint" if it is at most `limit * total`, else "wrong"."""
    if count == 0:
        return "ok"
    return "hint" if count <= limit * total else "wrong"

"""What was looked at in a recording, and what came of it."""

from __future__ import annotations

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
        topic: absolute; a transform is `PARENT -> CHILD`.
        check: "messages", "rate", "gaps", "jitter", "stamps", "pairs", "transforms" or "latency".
        verdict: "wrong" harms whoever uses the recording, "hint" may matter to some.
        found: one sentence.
        figures: what that is made of, with units in the names.
    """

    topic: str
    check: str
    verdict: Verdict
    found: str
    figures: Mapping[str, Figure] = field(default_factory=dict)


def of_share(count: int, total: int, most: float) -> Verdict:
    """None is ok, up to `most` of the total is a hint, more is wrong."""
    if count == 0:
        return "ok"
    return "hint" if count <= most * total else "wrong"

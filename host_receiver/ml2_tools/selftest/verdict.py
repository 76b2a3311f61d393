"""The verdict on one fact of config/facts.yaml, with its margin."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

type Measured = float | str | None


@dataclass(frozen=True)
class Verdict:
    """The verdict of recordings on one fact.

    Attributes:
        fact: its id in config/facts.yaml.
        measured: the value that was found, in `unit`; of a fact that was not judged, the reason.
        switch: KEY=VALUE of the configuration with which a headset that differs can go on.
        margin: how far the value is from what was expected, over what is tolerated; above 1 it
            differs. None if nothing was measured.
    """

    fact: str
    verdict: Literal["as assumed", "differs", "unknown"]
    measured: Measured = None
    unit: str = ""
    switch: str = ""
    margin: float | None = None


def as_assumed(fact: str, measured: Measured = None, unit: str = "") -> Verdict:
    """Returns the verdict on a fact that holds."""
    return Verdict(fact, "as assumed", measured, unit)


def differs(fact: str, measured: Measured, unit: str = "", switch: str = "") -> Verdict:
    """Returns the verdict on a fact that does not hold."""
    return Verdict(fact, "differs", measured, unit, switch)


def unknown(fact: str, why: str) -> Verdict:
    """Returns the verdict on a fact about which the recordings say nothing."""
    return Verdict(fact, "unknown", why)


def within(
    fact: str,
    measured: float,
    least: float,
    most: float,
    unit: str,
    switch: str = "",
) -> Verdict:
    """Returns the verdict on a value that is expected between `least` and `most`."""
    centre, tolerated = (least + most) / 2, (most - least) / 2
    margin = abs(measured - centre) / tolerated
    if margin <= 1:
        return Verdict(fact, "as assumed", measured, unit, margin=margin)
    return Verdict(fact, "differs", measured, unit, switch, margin)


def worst(verdicts: Sequence[Verdict]) -> Verdict:
    """Returns the one that differs most, else an unknown one, else the nearest to its limit."""
    order = "as assumed", "unknown", "differs"
    return max(verdicts, key=lambda it: (order.index(it.verdict), it.margin or 0.0))


def as_objects(verdicts: Sequence[Verdict]) -> list[dict[str, Any]]:
    """Returns the verdicts as objects for JSON."""
    keys = "fact", "verdict", "measured", "unit", "switch"
    return [{key: getattr(it, key) for key in keys} for it in verdicts]

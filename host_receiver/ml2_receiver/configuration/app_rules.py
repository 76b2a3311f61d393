"""The names of the ROS graph that an app on the headset may use: only those that a rule has.

A rule is a resolved name such as `/robot/joint_states`. Its segments may be `*`, which stands for
one segment, or `**`, for any number of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..table.key_values import is_rule
from ..table.reader import load_table

_PARAMETER_SERVICES = {
    "describe_parameters",
    "get_parameter_types",
    "get_parameters",
    "list_parameters",
    "set_parameters",
    "set_parameters_atomically",
}


# The keys of the section `app`, in the order of AppRules.
USES = ("subscribe", "publish", "call", "offer")


@dataclass(frozen=True)
class NameRules:
    """Rules for one use of names. Raises ValueError for a text that is no rule."""

    rules: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for rule in self.rules:
            if not is_rule(rule):
                raise ValueError(
                    "expected an absolute name such as /robot/scan, whose segments may be * and **,"
                    f" found {rule!r}"
                )

    def allow(self, name: str) -> bool:
        """Returns True if a rule has this resolved name.

        A rule with `*` or `**` never has a private name: a hidden one, /rosout, a service for
        parameters, or one of an eye camera.
        """
        if name in self.rules:
            return "*" not in name
        return not _is_private(name) and any(matches(rule, name) for rule in self.rules)


@dataclass(frozen=True)
class AppRules:
    """The names of ROS that an app may use; without rules, none."""

    subscribe: NameRules = NameRules()
    publish: NameRules = NameRules()
    call: NameRules = NameRules()
    offer: NameRules = NameRules()

    def forbidden(self, kind: str, name: str) -> str | None:
        """Returns why an app may not use a name for an opening or a publisher; None if it may."""
        key, rules = {
            "subscription": ("subscribe", self.subscribe),
            "transform": ("subscribe", self.subscribe),
            "publisher": ("publish", self.publish),
            "client": ("call", self.call),
            "service": ("offer", self.offer),
        }[kind]
        return None if rules.allow(name) else f"no rule in app.{key} has {name}"

    def of_subscriptions(self) -> "AppRules":
        """Returns what is left where anybody in the network could be the app."""
        return replace(AppRules(), subscribe=self.subscribe)


def matches(rule: str, name: str) -> bool:
    """Returns True if `name` is what `rule` stands for. Takes at most len(rule) * len(name)."""
    return _match(rule.split("/"), name.split("/"))


def _match(rule: Sequence[str], name: Sequence[str]) -> bool:
    at = position = 0
    # The last ** and where the segments that it stands for end: only these need another attempt.
    star, end = -1, 0
    while position < len(name):
        if at < len(rule) and rule[at] == "**":
            star, end = at, position
            at += 1
        elif at < len(rule) and rule[at] in ("*", name[position]):
            at, position = at + 1, position + 1
        elif star >= 0:
            end += 1
            at, position = star + 1, end
        else:
            return False
    return all(it == "**" for it in rule[at:])


def _is_private(name: str) -> bool:
    segments = name.split("/")
    eyes = {it.id for it in load_table().sections.values() if it.shows_eyes}
    return (
        name == "/rosout"
        or any(it.startswith("_") for it in segments)
        or segments[-1] in _PARAMETER_SERVICES
        or not eyes.isdisjoint(segments)
    )

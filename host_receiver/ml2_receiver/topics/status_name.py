"""Whose row of /diagnostics it is: "ml2_receiver: session", "robot1/ml2_receiver: session"."""

_NODE = "ml2_receiver"


def status_name(receiver: str, row: str) -> str:
    """The name of a status; `receiver` is as in --name, or empty."""
    return f"{receiver}/{_NODE}: {row}" if receiver else f"{_NODE}: {row}"


def split_status_name(name: str) -> tuple[str, str] | None:
    """Receiver and row, or None if somebody else says it."""
    node, colon, row = name.partition(": ")
    receiver, slash, last = node.rpartition("/")
    return (receiver, row) if colon and last == _NODE and bool(receiver) == bool(slash) else None

"""Names of rows in /diagnostics: "ml2_receiver: session", "robot1/ml2_receiver: session"."""

_NODE = "ml2_receiver"


def status_name(receiver: str, row: str) -> str:
    """Returns the name of a row; `receiver` is as in --name, or empty."""
    return f"{receiver}/{_NODE}: {row}" if receiver else f"{_NODE}: {row}"


def split_status_name(name: str) -> tuple[str, str] | None:
    """Returns receiver and row; None for a row of another node."""
    node, colon, row = name.partition(": ")
    receiver, slash, last = node.rpartition("/")
    return (receiver, row) if colon and last == _NODE and bool(receiver) == bool(slash) else None

"""ml2-receiver set: changes the configuration of a running receiver."""

import argparse

from ml2_receiver.commands.options import VALUES, Subparsers, add_receiver, complete
from ml2_receiver.errors import RosError
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.json_body import Scalar

from .live import PATIENCE_S, receiver_client, whom

_EPILOG = """\
Sets all values in one call: either all are valid together, or none is set. The receiver sends them
to the headset at once, and only the changed streams restart. `ml2-receiver devices` shows the
headset's answers; `ml2-receiver call save_config KEY` keeps a value for the next start. The same as
`ros2 param set`. An eye camera needs the word of the configuration file, too.

Exit code: 0, or 2 if the receiver refuses a value.

examples:
  ml2-receiver set world_left.enabled=true
  ml2-receiver set picture_center.mode=1280x720@30 picture_center.enabled=true
  ml2-receiver set depth_center.enabled=false --name robot1
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "set", help="change the configuration while `run` runs", epilog=_EPILOG
    )
    values = parser.add_argument(
        "values",
        nargs="+",
        type=_assignment,
        metavar="KEY=VALUE",
        help="`config show` lists keys and allowed values",
    )
    complete(values, VALUES)
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    values = {key: value_of(key, text) for key, text in options.values}
    with receiver_client(options.name, PATIENCE_S) as (node, client):
        reached = whom(node, client, options.name)
        is_done, message = client.set(values)
    answer = f"{reached}{message or 'done'}"
    if not is_done:
        raise RosError(answer)
    print(answer)
    return 0


def _assignment(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not key or not equals:
        raise argparse.ArgumentTypeError(f"expected KEY=VALUE, found {text!r}")
    return key, value


def value_of(key: str, text: str) -> Scalar:
    """Returns the value in the key's type, or the text itself, which the receiver then refuses."""
    rows = {
        f"{section.id}.{row.name}": row.type
        for section in load_table().sections.values()
        for row in section.keys.values()
    } | {"record.split_size_mb": "integer", "record.split_duration_s": "integer"}
    try:
        match rows.get(key):
            case "bool":
                return {"true": True, "false": False}[text]
            case "integer":
                return int(text)
            case "number":
                return float(text)
    except (KeyError, ValueError):
        pass
    return text

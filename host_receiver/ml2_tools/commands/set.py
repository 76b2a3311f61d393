"""ml2-receiver set: changes the configuration of a running receiver."""

import argparse

from ml2_receiver.commands.config import Subparsers
from ml2_receiver.commands.live import PATIENCE_S, receiver_client
from ml2_receiver.commands.options import add_name
from ml2_receiver.errors import RosError
from ml2_receiver.table.reader import load_table
from ml2_receiver.wire.json_body import Scalar

_EPILOG = """\
All values are set in one call: they are legal together, or none is taken. The receiver asks the
headset at once, and only the streams concerned restart; `ml2-receiver devices` has the headset's
answers. `ml2-receiver call save_config` keeps the values. It does what `ros2 param set` does.

Exit code: 0, or 2 when the receiver refuses a value, with its reason.

examples:
  ml2-receiver set world_left.enabled=true
  ml2-receiver set picture_center.mode=1280x720@30 picture_center.enabled=true
  ml2-receiver set depth_center.enabled=false --name robot1
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "set", help="change the configuration while `run` runs", epilog=_EPILOG
    )
    parser.add_argument(
        "values",
        nargs="+",
        type=_assignment,
        metavar="KEY=VALUE",
        help="`config show` lists keys and allowed values",
    )
    add_name(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    values = {key: _value(key, text) for key, text in options.values}
    with receiver_client(options.name, PATIENCE_S) as client:
        is_done, said = client.set(values)
    if not is_done:
        raise RosError(said)
    print(said or "done")
    return 0


def _assignment(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not key or not equals:
        raise argparse.ArgumentTypeError(f"expected KEY=VALUE, found {text!r}")
    return key, value


def _value(key: str, text: str) -> Scalar:
    """Of the key's type where it is one; what is wrong with it, the receiver says."""
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

"""ml2-receiver call: calls a service of a running receiver."""

import argparse

from ml2_receiver.commands.options import KEYS, Subparsers, add_receiver, complete
from ml2_receiver.errors import RosError

from .live import PATIENCE_S, receiver_client, whom

_SERVICES = {
    "start": "let the streams run",
    "stop": "stop all streams; the headset stays connected",
    "save_config": "write the values in force of these KEYs to the configuration file",
    "reload": "read that file again",
    "start_recording": "record into the folder of parameter record.folder; see `record --attach`",
    "stop_recording": "end that recording",
    "test_link": "measure the link to the headset; /diagnostics has the result in a few seconds",
}
_EPILOG = f"""\
services:
{"".join(f"  {name:<15} {what}\n" for name, what in _SERVICES.items())}
The same as `ros2 service call /ml2_receiver/SERVICE std_srvs/srv/Trigger`. save_config writes the
keys that the parameter save.keys names, and no others: anybody in the ROS domain can set some. To
enable streams, use `ml2-receiver set`.

Exit code: 0, or 2 if the receiver reports an error.

examples:
  ml2-receiver call stop
  ml2-receiver call save_config tf.layout picture_center.mode
  ml2-receiver call reload --name robot1
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "call", help="start or stop streams, save or reload the configuration", epilog=_EPILOG
    )
    parser.add_argument("service", choices=tuple(_SERVICES), help="see below")
    keys = parser.add_argument("keys", nargs="*", metavar="KEY", help="of save_config")
    complete(keys, KEYS)
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    if options.keys and options.service != "save_config":
        raise RosError(f"{options.service} takes no keys, found {' '.join(options.keys)}")
    with receiver_client(options.name, PATIENCE_S, [options.service]) as (node, client):
        reached = whom(node, client, options.name)
        is_done, message = client.call(options.service, options.keys)
    answer = f"{reached}{message or 'done'}"
    if not is_done:
        raise RosError(answer)
    print(answer)
    return 0

"""ml2-receiver compat: publishes the topics of the thesis's scripts."""

import argparse
import sys

from ml2_receiver.commands.options import Subparsers, add_receiver
from ml2_receiver.commands.ros_start import node_arguments, ros_needed
from ml2_receiver.commands.stopping import stop_signal

_EPILOG = """\
For programs that use the topics of the thesis's scripts (docs/from_the_thesis.md). Run it next to
`run`. It publishes the topics that differ by more than their name, while they have subscribers:

  OUT/CAMERA/metadata                 as lines of text
  OUT/gyro_left/imu, accel_left/imu   and so on, in the thesis's axes and frame ids
  OUT/gyro/imu, OUT/accel/imu         the thesis's older names, from the left unit
  /MagicLeap/config                   the configuration as JSON, after each message on /request

examples:
  ml2-receiver compat
  ml2-receiver compat --name robot1 --out /robot1/thesis

Arguments after --ros-args go to ROS 2.
"""


def add_parser(subparsers: Subparsers) -> None:
    parser = subparsers.add_parser(
        "compat", help="publish the topics of the thesis's scripts while `run` runs", epilog=_EPILOG
    )
    parser.add_argument(
        "--prefix", default="/magic_leap2", help="general.topic_name; default: /magic_leap2"
    )
    parser.add_argument(
        "--out", default="/thesis", help="prefix of the published topics; default: /thesis"
    )
    add_receiver(parser)
    parser.set_defaults(run=_run)


def _run(options: argparse.Namespace) -> int:
    stopping = stop_signal()
    with ros_needed():
        from ..compatibility.node import CompatibilityNode
    name = options.name
    prefix = f"/{name}{options.prefix}" if name else options.prefix
    node = CompatibilityNode(prefix, options.out, node_arguments(options.ros_args, name))
    print(f"ready to republish topics of {prefix} below {options.out}", flush=True)
    node.spin(stopping)
    for reason, count in node.losses.counts().items():
        print(f"not republished: {count}: {reason}", file=sys.stderr)
    return 0

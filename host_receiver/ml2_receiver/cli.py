"""The command ml2-receiver."""

import argparse
import sys
from collections.abc import Sequence

from .commands import config, export, latency, products, run
from .errors import ReceiverError
from .generated.version import VERSION


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one subcommand.

    Returns:
        0 when it did what it was asked to, 2 when it could not, with the reason on stderr.
    """
    parser = argparse.ArgumentParser(prog="ml2-receiver", description="Magic Leap 2 to ROS 2.")
    parser.add_argument("--version", action="version", version=VERSION)
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    config.add_parser(subparsers)
    export.add_parser(subparsers)
    latency.add_parser(subparsers)
    products.add_parser(subparsers)
    run.add_parser(subparsers)
    options = parser.parse_args(arguments)
    try:
        exit_code: int = options.run(options)
    except ReceiverError as error:
        print(error, file=sys.stderr)
        return 2
    return exit_code

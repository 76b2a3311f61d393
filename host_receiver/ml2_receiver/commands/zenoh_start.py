"""The options about Zenoh, and the output that they describe."""

import argparse
import os
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from ..configuration.config import Config
from ..errors import PackageError, ZenohError
from ..table.reader import load_table
from ..topics.control import ReceiverControl
from ..topics.fan_out import FanOut

if TYPE_CHECKING:
    from ..zenoh.output import ZenohOutput

_ENDPOINT = re.compile(r"[a-z][a-z0-9-]*/[^/?#]+:(\d{1,5})([?#].*)?", re.ASCII)
# On this machine, or encrypted.
_PRIVATE = re.compile(r"(tls|quic)/.*|[a-z]+/(127\.|localhost:|\[::1\]:).*", re.DOTALL)
_PLAINTEXT = "WARNING: {}: no encryption, and everybody on the way can read all streams"
_DOMAIN = re.compile(r"\d{1,3}", re.ASCII)
_PACKAGES = {"zenoh": "eclipse-zenoh", "xxhash": "xxhash"}


def add_zenoh(parser: argparse.ArgumentParser) -> None:
    """--zenoh, --zenoh-config and --no-ros."""
    parser.add_argument(
        "--zenoh",
        type=_endpoint,
        metavar="ENDPOINT",
        help="also publish through this Zenoh router, such as tcp/HOST:7447 or tls/HOST:7447, for"
        " ROS 2 nodes with rmw_zenoh and other programs",
    )
    parser.add_argument(
        "--zenoh-config",
        type=Path,
        metavar="FILE",
        help="configuration of the Zenoh session, such as its certificates and keys, in JSON5",
    )
    parser.add_argument(
        "--no-ros", action="store_true", help="publish only on Zenoh; needs no ROS 2"
    )


def check(options: argparse.Namespace) -> None:
    """Checks that the options fit together.

    Raises:
        ZenohError: they do not.
    """
    if options.no_ros and options.view:
        raise ZenohError("--view shows topics of ROS 2, so it does not go with --no-ros")
    if options.no_ros and options.start_paused:
        raise ZenohError("--start-paused waits for a service of ROS 2, which --no-ros lacks")
    if not options.no_ros:
        check_middleware(os.environ.get("RMW_IMPLEMENTATION", ""), options.zenoh)
    if options.zenoh is None and (options.no_ros or options.zenoh_config):
        given = "--no-ros" if options.no_ros else "--zenoh-config"
        raise ZenohError(
            f"{given} needs --zenoh",
            hint="Add --zenoh ENDPOINT; `ml2-receiver record --no-ros` needs neither.",
        )


def check_middleware(name: str, endpoint: str | None) -> None:
    """Checks that not both ROS and --zenoh publish on Zenoh: subscribers would get all twice.

    Args:
        name: ROS's identifier of the middleware, such as "rmw_fastrtps_cpp".
        endpoint: of --zenoh, or None.

    Raises:
        ZenohError: both do.
    """
    if endpoint is None or not name.startswith("rmw_zenoh"):
        return
    router = endpoint.partition("#")[0]  # what follows may hold a key
    raise ZenohError(
        f"the ROS 2 node itself is on Zenoh ({name}): with --zenoh, all would be published twice",
        hint=f"Leave out --zenoh, and set ZENOH_CONFIG_OVERRIDE='connect/endpoints=[\"{router}\"]'"
        " if rmw_zenoh shall use this router. Or add --no-ros. Or set"
        " RMW_IMPLEMENTATION=rmw_fastrtps_cpp, for a node on DDS.",
    )


def zenoh_output(
    options: argparse.Namespace,
    config: Config,
    sinks: FanOut,
    control: ReceiverControl,
    node: str,
    remapped: Callable[[str], str] = str,
) -> "ZenohOutput | None":
    """Returns the output, to be entered, or None without --zenoh.

    Args:
        node: its name after the remappings of ROS's arguments.
        remapped: returns the name of a topic after them.

    Raises:
        PackageError: a package of the extra `zenoh` is not installed.
        ZenohError: Zenoh does not take its configuration, or ROS_DOMAIN_ID is wrong.
    """
    if options.zenoh is None:
        return None
    try:
        from ..zenoh.configuration import session_configuration
        from ..zenoh.output import Identity, ZenohOutput
    except ModuleNotFoundError as error:
        package = _PACKAGES.get(error.name or "")
        if package is None:
            raise
        raise PackageError(
            f"--zenoh needs the package {package}, which is not installed",
            hint="Run in the clone `pip install './host_receiver[zenoh]'`.",
        ) from error
    session = session_configuration(options.zenoh, options.zenoh_config)
    if not _PRIVATE.fullmatch(options.zenoh):
        router = options.zenoh.partition("#")[0]
        print(_PLAINTEXT.format(router), file=sys.stderr, flush=True)
    identity = Identity(config.name, config.prefix, _domain(), remapped, node)
    return ZenohOutput(session, options.zenoh, identity, load_table(), sinks, control)


def _domain() -> int:
    text = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not _DOMAIN.fullmatch(text) or int(text) > 232:
        raise ZenohError(f"expected a ROS_DOMAIN_ID from 0 to 232, found {text!r}")
    return int(text)


def _endpoint(text: str) -> str:
    """Parses PROTOCOL/HOST:PORT, for argparse."""
    found = _ENDPOINT.fullmatch(text)
    if found is None or not 1 <= int(found[1]) <= 0xFFFF:
        raise argparse.ArgumentTypeError(
            "expected PROTOCOL/HOST:PORT, such as tcp/192.168.1.5:7447,"
            f" found {text.partition('#')[0]!r}"  # what follows may hold a key
        )
    return text

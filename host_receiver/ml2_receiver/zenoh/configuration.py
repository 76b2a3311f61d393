"""The configuration of the Zenoh session."""

import json
import re
from pathlib import Path

import zenoh

from ..configuration.whole_file import open_file
from ..errors import ZenohError, file_hint

# A put waits for room in the queue, and all lanes of the headset would wait with it. An image has
# several of the queue's batches of 64 KiB, and images of several cameras come at the same time.
# On a busy machine a wait of 2 ms loses more images than one of 5 ms. One of 50 ms, the default of
# rmw_zenoh, loses as many, but holds a put for 40 ms (docs/sites.md).
_DEFAULTS = {
    "mode": "client",
    "scouting/multicast/enabled": False,
    "timestamping/enabled": True,  # latched topics need it
    "transport/unicast/open_timeout": 2000,
    "transport/link/tx/queue/size/data_low": 16,
    "transport/link/tx/queue/congestion_control/drop/max_wait_before_drop_fragments": 5000,
}


def session_configuration(endpoint: str, file: Path | None) -> zenoh.Config:
    """Returns the user's configuration, with ours for what it leaves as Zenoh has it.

    Args:
        endpoint: the router, such as "tcp/host:7447".
        file: the user's, as JSON5, JSON or YAML.

    Raises:
        ZenohError: Zenoh does not take the file or the endpoint.
    """
    config = zenoh.Config() if file is None else _read(file)
    untouched = zenoh.Config()
    for key, value in _DEFAULTS.items():
        if config.get_json(key) == untouched.get_json(key):
            config.insert_json5(key, json.dumps(value))
    try:
        config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    except zenoh.ZError as error:
        router, hash, options = endpoint.partition("#")
        reason = _in_one_line(error).replace(hash + options, "")  # they may hold a key
        raise ZenohError(f"Zenoh does not take {router!r}: {reason}") from error
    return config


def _read(file: Path) -> zenoh.Config:
    try:
        open_file(file).close()
        return zenoh.Config.from_file(file)
    except OSError as error:
        raise ZenohError(
            f"{file} cannot be read: {error.strerror}", hint=file_hint(error, "give another file")
        ) from error
    except zenoh.ZError as error:
        raise ZenohError(
            f"{file} is no configuration of Zenoh: {_in_one_line(error)}",
            hint="Zenoh's DEFAULT_CONFIG.json5 explains every key.",
        ) from error


def _in_one_line(error: zenoh.ZError) -> str:
    """Returns what Zenoh says, without its place in Zenoh's sources and the quoted line."""
    text = re.sub(r" at /\S*\.rs:\d+\.?", "", str(error))
    if (message := re.search(r'msg: "(.*)", location', text)) is not None:
        return message[1]
    if (place := re.search(r"--> (\d+):(\d+)", text)) is not None:
        return f"line {place[1]}, column {place[2]}: {text.rpartition('= ')[2]}"
    return text

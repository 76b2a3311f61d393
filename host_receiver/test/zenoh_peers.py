"""Routers and other programs of Zenoh, for tests; as a program, a router on an endpoint."""

import json
import sys
from typing import Any

import zenoh

from free_port import reserve_port


def free_endpoint(protocol: str = "tcp") -> str:
    """An endpoint of this machine where nobody listens."""
    return f"{protocol}/127.0.0.1:{reserve_port()}"


def open_session(mode: str, values: dict[str, Any]) -> zenoh.Session:
    config = zenoh.Config()
    ours = {"mode": mode, "scouting/multicast/enabled": False, "scouting/delay": 0}
    for key, value in {**ours, **values}.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


def open_router(endpoint: str, **values: Any) -> zenoh.Session:
    return open_session("router", {"listen/endpoints": [endpoint], **values})


def open_client(endpoint: str, **values: Any) -> zenoh.Session:
    return open_session("client", {"connect/endpoints": [endpoint], **values})


if __name__ == "__main__":
    with open_router(sys.argv[1], **json.loads(sys.argv[2])):
        print("ready", flush=True)
        sys.stdin.read()

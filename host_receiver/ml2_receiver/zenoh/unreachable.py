"""The reason why a router cannot be reached, which Zenoh's errors do not have."""

import re
import socket
import ssl
from collections.abc import Mapping
from typing import Any

_PATIENCE_S = 1.0


def why_unreachable(endpoint: str, tls: Mapping[str, Any]) -> str:
    """Connects to the endpoint without Zenoh; returns what fails. It may block for 2 s.

    Args:
        endpoint: such as "tcp/host:7447".
        tls: the section transport/link/tls of Zenoh's configuration.
    """
    protocol, host, port = _parts(endpoint)
    if protocol not in ("tcp", "tls"):
        return "no answer"
    try:
        with socket.create_connection((host, port), _PATIENCE_S) as raw:
            if protocol == "tls":
                return _why_refused(raw, host, tls)
    except OSError as error:
        return error.strerror or str(error)
    return "it answers, but opens no session of Zenoh"


def _parts(endpoint: str) -> tuple[str, str, int]:
    protocol, _, address = re.split(r"[?#]", endpoint, maxsplit=1)[0].partition("/")
    host, _, port = address.rpartition(":")
    return protocol, host.strip("[]"), int(port)


def _why_refused(raw: socket.socket, host: str, tls: Mapping[str, Any]) -> str:
    try:
        context = ssl.create_default_context(cafile=tls["root_ca_certificate"])
        if tls["verify_name_on_connect"] is False:
            context.check_hostname = False
        if tls["connect_certificate"] and tls["connect_private_key"]:
            context.load_cert_chain(tls["connect_certificate"], tls["connect_private_key"])
    except OSError as error:
        return f"a file of transport/link/tls cannot be used: {error.strerror or error}"
    try:
        with context.wrap_socket(raw, server_hostname=host) as wrapped:
            wrapped.recv(1)  # a server refuses the client's certificate after the handshake
    except ssl.SSLCertVerificationError as error:
        return f"its certificate is refused: {error.verify_message}"
    except ssl.SSLError as error:
        words = (error.reason or str(error)).lower().replace("_", " ")
        return f"TLS fails: {words}"
    except TimeoutError:
        return "TLS succeeds, but it opens no session of Zenoh"
    return "it ends the connection"

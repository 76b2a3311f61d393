"""Listening sockets."""

import errno
import socket
from ipaddress import IPv6Address, ip_address

from ..errors import ListenError
from ..processes import listener_of

# A flood of refused connections must not fill it: a client that finds it full retries after 1 s.
_BACKLOG = 1024
# Larger than any control frame, so that an incomplete send() means that the peer does not read.
_SEND_BUFFER_BYTES = 128 * 1024


def listen(address: tuple[str, int]) -> socket.socket:
    """Returns a listening socket; port 0 lets the system choose, and `::` also accepts IPv4.

    Raises:
        ListenError: the receiver cannot listen on the address.
    """
    try:
        family, *_, resolved = socket.getaddrinfo(*address, type=socket.SOCK_STREAM)[0]
        listener = socket.create_server(
            resolved[:2],
            family=family,
            backlog=_BACKLOG,
            dualstack_ipv6=resolved[0] == "::" and socket.has_dualstack_ipv6(),
        )
    except OSError as error:
        reason, hint = _cannot_listen(address[1], error)
        raise ListenError(f"cannot listen on {text(address)}: {reason}", hint=hint) from error
    # Linux copies these options to every accepted connection.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER_BYTES)
    return listener


def _cannot_listen(port: int, error: OSError) -> tuple[str, str]:
    """Returns why listening failed, and what to do."""
    match error.errno:
        case errno.EADDRINUSE:
            holder = listener_of(port)
            hint = "Stop it, or choose another port with --listen."
            if holder is not None and holder.is_ours:
                hint += " `ml2-receiver record --attach` has it record."
            return f"the port is used by {holder or 'a process of another user'}", hint
        case errno.EACCES:
            hint = "Choose a port above 1023 with --listen."
        case _:
            hint = "Choose an address of this machine with --listen; 0.0.0.0 means all of them."
    return error.strerror or str(error), hint


def everywhere(port: int) -> tuple[str, int]:
    """Returns the address of all interfaces, with IPv6 if this machine has it."""
    return ("::" if socket.has_dualstack_ipv6() else "0.0.0.0"), port


def peer_host(host: str) -> str:
    """Returns the host that accept() gave, with an IPv4-mapped address as IPv4."""
    address = ip_address(host)
    mapped = address.ipv4_mapped if isinstance(address, IPv6Address) else None
    return host if mapped is None else str(mapped)


def text(address: tuple[str, int]) -> str:
    """Returns an address from getsockname() as HOST:PORT."""
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"

"""The sockets that are listened on."""

import errno
import socket
from ipaddress import IPv6Address, ip_address

from ..errors import ListenError
from ..processes import listener_of

# A flood that is turned away must not fill it: who finds it full tries again a second later.
_BACKLOG = 1024
# Takes every control frame whole, so that one send() tells whether the peer reads at all.
_SEND_BUFFER_BYTES = 128 * 1024


def listen(address: tuple[str, int]) -> socket.socket:
    """A socket for Server; port 0 lets the system choose, and `::` takes IPv4 peers, too.

    Raises:
        ListenError: the address cannot be listened on.
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
    # Linux gives these to every connection it accepts.
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER_BYTES)
    return listener


def _cannot_listen(port: int, error: OSError) -> tuple[str, str]:
    """The reason, and what to do."""
    match error.errno:
        case errno.EADDRINUSE:
            holder = listener_of(port) or "a process of another user"
            return f"the port is used by {holder}", "Stop it, or choose another port with --listen."
        case errno.EACCES:
            hint = "Choose a port above 1023 with --listen."
        case _:
            hint = "Choose an address of this machine with --listen; 0.0.0.0 means all of them."
    return error.strerror or str(error), hint


def everywhere(port: int) -> tuple[str, int]:
    """All interfaces, with IPv6 where this machine has it."""
    return ("::" if socket.has_dualstack_ipv6() else "0.0.0.0"), port


def peer_host(host: str) -> str:
    """A peer's host as accept() has it; that of an IPv4 peer as IPv4."""
    address = ip_address(host)
    mapped = address.ipv4_mapped if isinstance(address, IPv6Address) else None
    return host if mapped is None else str(mapped)


def text(address: tuple[str, int]) -> str:
    """HOST:PORT of what getsockname() has."""
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"

"""Admits only browsers of this machine that have the token to the page and its data."""

import hmac
import json
import re
import secrets
from collections.abc import Sequence

# The port is free, because `ssh -L` may offer the page on another one. The name is not: a web page
# whose own name leads to this machine must not be answered.
_OWN_HOST = re.compile(r"(127\.0\.0\.1|localhost|\[::1\])(:\d{1,5})?", re.ASCII)


def is_own_host(hosts: Sequence[str]) -> bool:
    """Returns True if a request has one header Host, and it names this machine."""
    return len(hosts) == 1 and _OWN_HOST.fullmatch(hosts[0]) is not None


def is_own_origin(origins: Sequence[str], hosts: Sequence[str]) -> bool:
    """Returns True if a request has one header Origin, and it is that of the page itself."""
    return is_own_host(hosts) and list(origins) == [f"http://{hosts[0]}"]


class Token:
    """A random token that a browser must send first. Thread-safe."""

    def __init__(self) -> None:
        self.text = secrets.token_urlsafe(32)

    def opens(self, message: str | bytes) -> bool:
        """Returns True if a message is `{"token": "..."}` with this token."""
        try:
            found = json.loads(message)
        except (ValueError, RecursionError):
            return False
        given = found.get("token") if isinstance(found, dict) else None
        # Text that is no UTF-8 cannot be the token, and must not raise an error.
        return isinstance(given, str) and hmac.compare_digest(
            given.encode("utf-8", "replace"), self.text.encode()
        )

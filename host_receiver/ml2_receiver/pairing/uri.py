"""The URI that `ml2-receiver pair` shows and a device reads."""

import re
from dataclasses import dataclass
from typing import Self
from urllib.parse import parse_qs, urlsplit

from ..errors import PairingError

_SCHEME = "ml2s"
_FINGERPRINT = re.compile("[0-9a-f]{64}")
_TOKEN = re.compile("[0-9a-f]{32}")


@dataclass(frozen=True)
class PairingUri:
    """The address of the pairing port, the receiver's fingerprint, and the token."""

    host: str
    port: int
    fingerprint: str
    token: str

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        query = f"fp={self.fingerprint}&token={self.token}"
        return f"{_SCHEME}://{host}:{self.port}?{query}"

    @classmethod
    def parse(cls, text: str) -> Self:
        """Parses a URI.

        Raises:
            PairingError: it is not a pairing URI. The message does not repeat the text, as it may
                contain a token.
        """
        try:
            parts = urlsplit(text)
            query = {key: values[0] for key, values in parse_qs(parts.query).items()}
            uri = cls(parts.hostname or "", parts.port or 0, query["fp"], query["token"])
        except (ValueError, KeyError):
            uri = cls("", 0, "", "")
        has_address = text.startswith(f"{_SCHEME}://") and uri.host and uri.port
        has_secrets = _FINGERPRINT.fullmatch(uri.fingerprint) and _TOKEN.fullmatch(uri.token)
        if not (has_address and has_secrets):
            raise PairingError("expected ml2s://HOST:PORT?fp=...&token=..., as `pair` shows it")
        return uri

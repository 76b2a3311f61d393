"""The JSON bodies of a pairing; PROTOCOL.md says what their keys mean."""

from dataclasses import dataclass

from .json_body import JsonBody, check_text
from .messages import ID_CHARACTERS, NAME_CHARACTERS


@dataclass(frozen=True)
class PairChallenge(JsonBody):
    nonce: str
    name: str
    software: str

    def __post_init__(self) -> None:
        check_text("name", self.name, NAME_CHARACTERS)
        check_text("software", self.software, ID_CHARACTERS)


@dataclass(frozen=True)
class Pair(JsonBody):
    token: str
    name: str
    device_id: str
    certificate: str
    signature: str

    def __post_init__(self) -> None:
        check_text("name", self.name, NAME_CHARACTERS)
        check_text("device_id", self.device_id, ID_CHARACTERS)


@dataclass(frozen=True)
class Paired(JsonBody):
    name: str
    port: int

    def __post_init__(self) -> None:
        check_text("name", self.name, NAME_CHARACTERS)
        if not 1 <= self.port <= 0xFFFF:
            raise ValueError(f"port: expected 1 to 65535, found {self.port}")

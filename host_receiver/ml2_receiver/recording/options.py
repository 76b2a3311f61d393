"""The options of a recording."""

from dataclasses import dataclass


@dataclass(frozen=True)
class RecordingOptions:
    """Options; `topics` are patterns, none means all; a size or duration of 0 is no limit."""

    compression: str = "none"
    topics: tuple[str, ...] = ()
    split_size_mb: int = 0
    split_duration_s: int = 0

    @property
    def split_bytes(self) -> int:
        return self.split_size_mb * 1_000_000

    @property
    def split_duration_ns(self) -> int:
        return self.split_duration_s * 1_000_000_000

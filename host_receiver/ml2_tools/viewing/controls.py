"""The part of the configuration that a browser may change, with its legal values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Section
from ml2_receiver.wire.json_body import Scalar

from .state import is_eye

# Services of the receiver that a browser may call.
SERVICES = frozenset(
    ("start", "stop", "test_link", "save_config", "start_recording", "stop_recording")
)
_ENABLED, _MODE = "enabled", "mode"


@dataclass(frozen=True)
class Control:
    """The keys of one section that a browser may set.

    Attributes:
        doc: the section's description.
        modes: each mode as stream of the device and "WIDTHxHEIGHT@RATE"; none but for cameras.
        allowed: the legal values of each key. Not all of them are legal together.
    """

    section: str
    doc: str
    modes: tuple[tuple[int, str], ...]
    allowed: Mapping[str, tuple[Scalar, ...]]

    def takes(self, values: Mapping[str, object]) -> bool:
        """Returns True if each key may be set, and each value is legal by itself."""
        # True is equal to 1, and would be a legal stream.
        return bool(values) and all(
            any(type(it) is type(value) and it == value for it in self.allowed.get(key, ()))
            for key, value in values.items()
        )

    def parameters(self) -> Iterator[str]:
        """Yields the names of the receiver's parameters for the keys."""
        return (f"{self.section}.{key}" for key in self.allowed)

    def described(self) -> dict[str, Any]:
        """Returns what a page needs to show it, for JSON."""
        formats = self.allowed.get("format", ())
        return {"section": self.section, "doc": self.doc, "modes": self.modes, "formats": formats}


def controls(with_eyes: bool) -> dict[str, Control]:
    """Returns the controls by section, in the order of the table; with or without eye cameras."""
    table = load_table()
    eyes = {table.streams[it].section for it in table.streams if is_eye(it)}
    return {
        it.id: _control(it)
        for it in table.sections.values()
        if _ENABLED in it.keys and (with_eyes or it.id not in eyes)
    }


def _control(section: Section) -> Control:
    modes = tuple(
        (mode.stream, f"{width}x{height}@{rate}")
        for mode in section.modes
        for width, height in mode.resolutions
        for rate in mode.rates
    )
    allowed: dict[str, tuple[Scalar, ...]] = {_ENABLED: (True, False)}
    if modes:
        allowed |= {it: section.keys[it].allowed for it in ("stream", "format")}
        allowed[_MODE] = tuple(dict.fromkeys(mode for _, mode in modes))
    return Control(section.id, section.doc, modes, allowed)

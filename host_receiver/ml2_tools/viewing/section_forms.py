"""The part of the configuration that a browser may change, with its legal values."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ml2_receiver.table.key_values import LINK_WORDS, accepts
from ml2_receiver.table.reader import load_table
from ml2_receiver.table.stream_table import Key, Section

from ..monitoring.topic_table import Rows, number_of

# Services of the receiver that a browser may call.
SERVICES = frozenset(
    ("start", "stop", "test_link", "save_config", "start_recording", "stop_recording")
)
# Keys that a browser may set in each section that has them.
_KEYS = ("enabled", "stream", "format", "quality", "link")
# Stands for the keys of a camera's resolution and rate, which are set together.
_MODE = "mode"
_CONNECTED = "connected"


@dataclass(frozen=True)
class SectionForm:
    """The keys of one section that a browser may set.

    Attributes:
        doc: the section's description.
        modes: each mode as stream of the device and "WIDTHxHEIGHT@RATE"; none but for cameras.
        keys: the keys beside the mode. Not all of their legal values are legal together.
    """

    section: str
    doc: str
    modes: tuple[tuple[int, str], ...]
    keys: Mapping[str, Key]

    def takes(self, values: Mapping[str, object]) -> bool:
        """Returns True if each key may be set, and each value is legal by itself."""
        return bool(values) and all(self._takes(key, value) for key, value in values.items())

    def _takes(self, name: str, value: object) -> bool:
        if name == _MODE:
            return any(value == mode for _, mode in self.modes)
        key = self.keys.get(name)
        return key is not None and accepts(value, key) and (not key.allowed or value in key.allowed)

    def parameters(self) -> Iterator[str]:
        """Yields the names of the receiver's parameters for the keys."""
        return (f"{self.section}.{key}" for key in (*self.keys, *([_MODE] if self.modes else [])))

    def described(self) -> dict[str, Any]:
        """Returns what a page needs to show it, for JSON; null for a key that it has not."""
        format, quality = self.keys.get("format"), self.keys.get("quality")
        return {
            "section": self.section,
            "doc": self.doc,
            "modes": self.modes,
            "isSwitch": "enabled" in self.keys,
            "formats": format.allowed if format else (),
            "quality": (quality.minimum, quality.maximum) if quality else None,
            "link": LINK_WORDS if "link" in self.keys else None,
        }


def receiver_state(rows: Rows) -> dict[str, Any]:
    """Returns what the receiver does at present, on which it depends what a browser may call."""
    session, recording = rows.get("session", {}), rows.get("recording", {})
    states = [it for key, it in session.items() if key.startswith("state.")]
    is_on = recording.get("state") == "recording"
    return {
        "has_headset": session.get("state") == _CONNECTED,
        "is_stopped": bool(states) and all(it.startswith("paused") for it in states),
        "recording_s": (number_of(recording.get("duration_s")) or 0) if is_on else None,
    }


def section_forms(with_eyes: bool) -> dict[str, SectionForm]:
    """Returns the forms by section, in the order of the table; with or without eye cameras."""
    table = load_table()
    return {
        it.id: _form(it)
        for it in table.sections.values()
        if any(key in it.keys for key in _KEYS) and (with_eyes or not it.shows_eyes)
    }


def _form(section: Section) -> SectionForm:
    modes = tuple(
        (mode.stream, f"{width}x{height}@{rate}")
        for mode in section.modes
        for width, height in mode.resolutions
        for rate in mode.rates
    )
    keys = {it: section.keys[it] for it in _KEYS if it in section.keys}
    return SectionForm(section.id, section.doc, modes, keys)

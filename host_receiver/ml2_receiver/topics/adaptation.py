"""The row `adaptation` of /diagnostics: what the headset has lowered for the link."""

from collections.abc import Mapping

from ..wire.messages import StreamStatus

ADAPTATION = "adaptation"
NOTHING_LOWERED = "nothing is lowered"
LOWERED = "lowered for the link"
_WORDS = {"quality": "quality {}", "rate_hz": "{} Hz"}


def adaptation_values(streams: Mapping[str, StreamStatus]) -> dict[str, str]:
    """Returns the values of the row: `<stream>.quality` and `<stream>.rate_hz`, where lowered."""
    return {
        f"{id}.{key}": str(value)
        for id, status in streams.items()
        for key in _WORDS
        if (value := getattr(status, key)) is not None
    }


def lowered_streams(row: Mapping[str, str]) -> dict[str, str]:
    """Returns each lowered stream with its values in words, such as "quality 60, 15 Hz".

    Args:
        row: the values of the row, which may also have its message.
    """
    found: dict[str, list[str]] = {}
    for name, value in row.items():
        stream, _, key = name.rpartition(".")
        if key in _WORDS:
            found.setdefault(stream, []).append(_WORDS[key].format(value))
    return {stream: ", ".join(words) for stream, words in found.items()}


def adaptation_message(values: Mapping[str, str]) -> str:
    """Returns the message of the row with these values; streams with the same words together."""
    alike: dict[str, list[str]] = {}
    for stream, words in lowered_streams(values).items():
        alike.setdefault(words, []).append(stream)
    found = [f"{', '.join(streams)}: {words}" for words, streams in alike.items()]
    return f"{LOWERED}: {'; '.join(found)}" if found else NOTHING_LOWERED

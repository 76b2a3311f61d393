"""The headsets in a recording, and what belongs to which."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

from ml2_receiver.errors import ProtocolError, RecordingError
from ml2_receiver.topics.config_topic import ConfigText
from ml2_receiver.topics.plain_messages import decode_string

from .decoding import decoder

_CONFIG_SUFFIX, _STRING = "/config", "std_msgs/msg/String"
_TRANSFORMS = "tf2_msgs/msg/TFMessage"


@dataclass(frozen=True)
class Headset:
    """One headset of a recording.

    Attributes:
        config: its answer to the first configuration.
        prefix: the prefix of its topics.
        others: the prefixes of the other headsets.
    """

    config: ConfigText
    prefix: str
    others: frozenset[str]

    def has(self, topic: str) -> bool:
        """Returns False for a topic of another headset."""
        owners = [it for it in (self.prefix, *self.others) if topic.startswith(f"{it}/")]
        return max(owners, key=len, default=self.prefix) == self.prefix

    def has_message(self, type: str, payload: bytes) -> bool:
        """Returns False for transforms of another headset, on the topic that all share."""
        if not self.others or type != _TRANSFORMS:
            return True
        try:
            (first, *_) = decoder(_TRANSFORMS)(payload).transforms
        except ValueError:
            return True
        name = str(first.child_frame_id).rpartition("/")[0]
        owners = {it for it in (self.prefix, *self.others) if _may_have_name(it, name)}
        return not owners or self.prefix in owners


def _may_have_name(prefix: str, name: str) -> bool:
    """Returns True if a receiver may have a prefix and the --name that is before frame ids."""
    return prefix.startswith(f"/{name}/") if name else prefix.count("/") == 1


def config_topics(types: Mapping[str, str]) -> set[str]:
    """Returns the topics that may have the configuration of a headset."""
    return {name for name, it in types.items() if name.endswith(_CONFIG_SUFFIX) and it == _STRING}


def choose(path: Path, firsts: Mapping[str, bytes | None], wanted: str | None) -> Headset:
    """Finds the headsets of a recording by what their topics say, and chooses one.

    Args:
        firsts: the first payload of each of config_topics(), or None.
        wanted: a prefix, the part of it before the first slash, or the name of the device; None
            if there has to be only one.

    Raises:
        RecordingError: there is none, none of the wanted name, or several.
    """
    found = _headsets(path, firsts)
    prefixes = [it for it in found if wanted is None or wanted in _names(it, found[it])]
    if len(prefixes) == 1:
        (prefix,) = prefixes
        return Headset(found[prefix], prefix, frozenset(found) - {prefix})
    choices = ", ".join(sorted(found))
    devices = ", ".join(sorted({it.headset for it in found.values()}))
    hint = f"Choose one of these with --headset, or by its device's name: {devices}."
    if prefixes:
        of = f" of the name {wanted!r}" if wanted is not None else ""
        raise RecordingError(f"{path} has several headsets{of}: {choices}", hint=hint)
    raise RecordingError(f"{path} has no headset {wanted!r}; it has {choices}", hint=hint)


def _names(prefix: str, config: ConfigText) -> set[str]:
    relative = prefix.removeprefix("/")
    return {prefix, relative, relative.partition("/")[0], config.headset}


def _headsets(path: Path, firsts: Mapping[str, bytes | None]) -> dict[str, ConfigText]:
    """The configurations by prefix: other nodes may name a topic .../config, too."""
    if not firsts:
        raise RecordingError(
            f"{path} is not a recording of ml2-receiver: it has no topic .../config"
        )
    found: dict[str, ConfigText] = {}
    mistakes: dict[str, Exception] = {}
    for topic, payload in sorted(firsts.items()):
        try:
            if payload is not None:
                prefix = topic.removesuffix(_CONFIG_SUFFIX)
                found[prefix] = ConfigText.parse(decode_string(payload))
        except (ValueError, ProtocolError) as error:
            mistakes[topic] = error
    for topic, mistake in mistakes.items() if not found else ():
        raise RecordingError(f"{path}: {topic}: {mistake}") from mistake
    if not found:
        topic = min(firsts)
        raise RecordingError(f"{path} has no message on {topic}: no headset was connected")
    # An app's own topics are below its headset's, whatever they say.
    return {it: found[it] for it in found if not _is_custom(it, found)}


def _is_custom(prefix: str, prefixes: Collection[str]) -> bool:
    return any(f"{prefix}/".startswith(f"{it}/custom/") for it in prefixes)

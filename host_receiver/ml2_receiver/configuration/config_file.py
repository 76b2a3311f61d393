"""The user's config.yaml: where it is, and how the present configuration is written to it."""

import io
from collections.abc import Iterator, Mapping, MutableMapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any, Self

from ..errors import ConfigError, Problem
from ..table.reader import load_table
from ..user_folder import user_folder
from .config import Config, load_config, parse_config
from .config_rules import MODE_KEYS, Values, mode_of
from .parameter_file import MAX_BYTES, chosen, is_pattern
from .whole_file import read_file, replace_file

_INDENT = {"mapping": 2, "sequence": 4, "offset": 2}
_WIDE = 4096  # so that ruamel breaks no line of the user's


@dataclass(frozen=True)
class ConfigFile:
    """The file at `path`; if it is optional and does not exist, the packaged file.

    `node` is the receiver's, as for load_config.
    """

    path: Path
    is_optional: bool = False
    node: str | None = None

    @classmethod
    def of_user(cls, node: str | None = None) -> Self:
        """`config.yaml` in user_folder(), or in `ml2_receiver` beside it, where it once was."""
        folder = user_folder()
        path, old = folder / "config.yaml", folder.with_name("ml2_receiver") / "config.yaml"
        return cls(old if old.exists() and not path.exists() else path, True, node)

    @property
    def is_packaged(self) -> bool:
        """True if the packaged file is used because the user's file does not exist."""
        return self.is_optional and not self.path.exists()

    def load(self) -> Config:
        """Reads it.

        Raises:
            ConfigError: as load_config.
        """
        return (
            parse_config(_packaged(), self.path.parent, self.node)
            if self.is_packaged
            else load_config(self.path, self.node)
        )

    def save(self, config: Config) -> None:
        """Writes `config` to it, all or nothing; its comments and order stay.

        Raises:
            ConfigError: it cannot be written, or what stands there now is no configuration.
        """
        path = self.path.resolve()
        try:
            data = _packaged() if self.is_packaged else read_file(path, MAX_BYTES)
            data = _edited(data, path.parent, config.values, self.node)
            if parse_config(data, path.parent, self.node).values != config.values:
                raise _unwritable(self.path, "expected one place for each key")
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            replace_file(path, data)
        except OSError as error:
            raise _unwritable(self.path, error.strerror) from error
        except ConfigError as error:
            raise ConfigError(error.problems, str(self.path)) from error


def _packaged() -> bytes:
    return resources.files("ml2_receiver").joinpath("data/config.yaml").read_bytes()


def _unwritable(path: Path, reason: str | None) -> ConfigError:
    return ConfigError([Problem(0, "", "", f"cannot be written: {reason}")], str(path))


def _edited(data: bytes, folder: Path, values: Values, node: str | None) -> bytes:
    """The file with other values; keys that it does not have are added where they are not as
    the table has them."""
    from ruamel.yaml import YAML  # takes as long to import as the rest
    from ruamel.yaml.error import YAMLError

    before = parse_config(data, folder, node).values
    yaml = YAML()
    yaml.preserve_quotes = True
    yaml.width = _WIDE
    yaml.indent(**_INDENT)
    try:
        document = yaml.load(data)
    except YAMLError as error:  # YAML 1.2, and each key once, where the reader takes more
        line = getattr(getattr(error, "problem_mark", None), "line", -1) + 1
        reason = getattr(error, "problem", None) or str(error)
        problem = Problem(line, "", "", f"cannot be written: {' '.join(reason.split())}")
        raise ConfigError([problem]) from error
    places = _of_node(document, node)
    sections = load_table().sections.values()
    names = {f"{s.id}.{it.name}" for s in sections for it in s.keys.values() if it.type == "names"}
    cameras = [it.id for it in sections if it.modes]
    modes = {f"{it}.mode": it for it in cameras if any(_places(places, f"{it}.mode"))}
    in_modes = {f"{camera}.{key}" for camera in modes.values() for key in MODE_KEYS}
    for name, value in values.items():
        if value == before[name]:
            continue
        keys, key = next(_places(places, name), (None, ""))
        if keys is None and name in in_modes:
            continue
        if keys is None:
            keys, key = _new_place(places, name)
        keys[key] = str(value).split() if name in names else value
    for name, camera in modes.items():
        keys, key = next(_places(places, name))
        keys[key] = mode_of(camera, values)
    text = io.BytesIO()
    yaml.dump(document, text)
    return text.getvalue()


# The ros__parameters of each node, by its name. The first node that has a key decides its value.
type _Parameters = Mapping[str, MutableMapping[str, Any]]


def _places(own: _Parameters, name: str) -> Iterator[tuple[MutableMapping[str, Any], str]]:
    """Yields the places of a key, that in force first: under its section, or with a dot."""
    section, _, key = name.partition(".")
    for sections in own.values():
        if name in sections:
            yield sections, name
        elif key in sections.get(section, {}):
            yield sections[section], key


def _new_place(own: _Parameters, name: str) -> tuple[MutableMapping[str, Any], str]:
    section, _, key = name.partition(".")
    paths = sorted(own, key=is_pattern)
    return own[paths[0]].setdefault(section, {}), key


def _of_node(document: Mapping[str, Any], node: str | None) -> _Parameters:
    blocks = list(_blocks(document, ""))
    taken = chosen([name for name, _ in blocks], node)
    return {name: sections for name, sections in reversed(blocks) if name in taken}


def _blocks(
    document: Mapping[str, Any], namespace: str
) -> Iterator[tuple[str, MutableMapping[str, Any]]]:
    for name, node in document.items():
        if not isinstance(node, Mapping):
            continue
        path = f"{namespace}/{str(name).removeprefix('/')}"
        if "ros__parameters" in node:
            yield path, node["ros__parameters"]
        else:
            yield from _blocks(node, path)

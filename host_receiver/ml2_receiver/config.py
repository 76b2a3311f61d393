"""Reads config.yaml: which streams shall run, and how."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from .config_rules import Values, camera_problems, key_problems, read_values
from .errors import ConfigError, Problem
from .parameter_file import MAX_BYTES, read_parameters
from .table import Stream, load_table


@dataclass(frozen=True)
class Config:
    """A valid configuration.

    `values` has every key, by "section.key"; `name` is empty, or tells this headset from others.
    """

    values: Values
    name: str = ""

    @property
    def prefix(self) -> str:
        """Where all relative topics live, "/magic_leap2" or "/NAME/magic_leap2"."""
        prefix = str(self.values["general.topic_name"]).removeprefix("/")
        return f"/{self.name}/{prefix}" if self.name else f"/{prefix}"

    @property
    def frame_prefix(self) -> str:
        """What frame ids begin with."""
        return f"{self.name}/" if self.name else ""

    @cached_property
    def requests(self) -> Mapping[str, Values]:
        """For each stream that shall run, in the order of the table, what CONFIGURE carries."""
        streams = load_table().streams.values()
        running = [stream for stream in streams if stream.when and _runs(stream, self.values)]
        if running:
            running += [stream for stream in streams if stream.when is None]
        return {stream.id: _request(stream, self.values) for stream in running}


def load_config(path: Path) -> Config:
    """Reads a ROS 2 parameter file; keys that are not in it have the table's defaults.

    Raises:
        ConfigError: with everything that is wrong in it, in the order of its lines.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        return parse_config(data)
    except OSError as error:
        problem = Problem(0, "", "", f"cannot be read: {error.strerror}")
        raise ConfigError([problem], str(path)) from error
    except ConfigError as error:
        raise ConfigError(error.problems, str(path)) from error


def parse_config(data: bytes) -> Config:
    """As load_config, from the bytes of the file."""
    table = load_table()
    parameters, problems = read_parameters(data)
    problems += key_problems(parameters, table.sections)
    values = read_values(parameters, table.sections)
    for section in table.sections.values():
        problems += camera_problems(section, parameters, values)
    if problems:
        raise ConfigError(sorted(problems, key=lambda problem: problem.line))
    return Config(values)


def _runs(stream: Stream, values: Values) -> bool:
    when = stream.when or {}
    return all(values[f"{stream.section}.{key}"] == value for key, value in when.items())


def _request(stream: Stream, values: Values) -> Values:
    return {name.rpartition(".")[2]: values[name] for name in stream.values}

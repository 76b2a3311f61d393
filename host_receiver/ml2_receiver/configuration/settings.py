"""The configuration as it changes while the receiver runs."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Self

from ..errors import ConfigError, Problem
from ..table.reader import load_table
from ..table.stream_table import CAMERA_KEYS, Section
from ..wire.json_body import Scalar
from .calibration import Calibration
from .config import Config, read_calibrations
from .config_rules import (
    Values,
    camera_problems,
    key_problems,
    marker_problems,
    mode_of,
    read_values,
    without_modes,
)
from .operators import operators_problems
from .parameter_file import MAX_SHOWN, Parameter


@dataclass(frozen=True)
class Settings:
    """The values that were set, key by key, and the resulting configuration.

    `values` has every key as it was set last. Where those of a camera are not legal together, its
    last legal ones stay in `config`, and `pending` says what is missing. `operators` has the values
    that are the operator's own: of the file and of the start.
    """

    values: Values
    config: Config
    operators: Values
    pending: tuple[Problem, ...] = ()

    @classmethod
    def of(cls, config: Config) -> Self:
        return cls(config.values, config, config.values)

    def changed(
        self, changes: Mapping[str, object], *, may_wait: bool = False, by_peer: bool = False
    ) -> "Settings":
        """The settings with some keys changed; `<camera>.mode`, "1280x720@30", stands for three.

        The order of the changes does not matter: a mode and a key that contradict are refused.

        Args:
            may_wait: a value that is legal, but not with the camera's others, waits for them.
            by_peer: anybody in the ROS domain wants it, who may not change what is the operator's.

        Raises:
            ConfigError: with what config check would say.
        """
        sections = load_table().sections
        given = {name: _parameter(value) for name, value in changes.items()}
        changed, problems = without_modes(given, sections)
        shown = {name: _parameter(value) for name, value in self.values.items()} | changed
        if problems := problems or list(key_problems(shown, sections)):
            raise ConfigError(problems, "")
        values = read_values(shown, sections)
        if by_peer and (problems := list(operators_problems(self.operators, values))):
            raise ConfigError(problems, "")
        if problems := [it for it in marker_problems(shown, values) if it.key == "markers.enabled"]:
            raise ConfigError(problems, "")  # a wrong dictionary may wait; the headset refuses it
        pending = [
            problem
            for section in sections.values()
            for problem in camera_problems(section, shown, values)
        ]
        touched = {_section(name) for name in changed}
        wrong = [problem for problem in pending if _section(problem.key) in touched]
        if wrong and not (may_wait and all(_is_ever_legal(name, values[name]) for name in changed)):
            raise ConfigError(wrong, "")
        waiting = {f"{_section(problem.key)}.{key}" for problem in pending for key in CAMERA_KEYS}
        legal = values | {name: self.config.values[name] for name in waiting}
        cameras, mistakes = read_calibrations(legal, self.config.folder, touched)
        if mistakes:
            raise ConfigError(list(mistakes.values()), "")
        before = self.config.cameras.items()
        kept = {id: it for id, it in before if f"{id}.calibration" not in changed}
        config = replace(self.config, values=legal, cameras=kept | cameras)
        operators = self.operators if by_peer else values
        return Settings(values, config, operators, tuple(pending))

    def calibrated(self, camera: str, calibration: Calibration) -> "Settings":
        """Returns these settings with a calibration, used until the key `calibration` is set."""
        cameras = {**self.config.cameras, camera: calibration}
        return replace(self, config=replace(self.config, cameras=cameras))

    def parameters(self) -> dict[str, Scalar]:
        """Returns the ROS parameters: `values`, and the configured mode of each camera."""
        modes = {mode_name(it): mode_of(it.id, self.config.values) for it in cameras()}
        return {**self.values, **modes}


def config_of(values: Mapping[str, object]) -> Config:
    """Returns the configuration of a running receiver by its ROS parameters.

    Calibrations are left out, since their files may be elsewhere.

    Raises:
        ConfigError: a value is not one that its key can have.
    """
    shown = {name: _parameter(value) for name, value in values.items()}
    sections = load_table().sections
    if problems := list(key_problems(shown, sections)):
        raise ConfigError(problems, "")
    return Config(read_values(shown, sections))


def cameras() -> list[Section]:
    """The sections that have a mode."""
    return [section for section in load_table().sections.values() if section.modes]


def mode_name(camera: Section) -> str:
    return f"{camera.id}.mode"


def _is_ever_legal(name: str, value: Scalar) -> bool:
    section, _, key = name.partition(".")
    allowed = load_table().sections[section].keys[key].allowed
    return not allowed or value in allowed


def _section(name: str) -> str:
    return name.partition(".")[0]


def _parameter(value: object) -> Parameter:
    """Returns the value as the reader of files would."""
    if isinstance(value, bool | int | float | str):
        return Parameter(0, value, json.dumps(value, ensure_ascii=False)[:MAX_SHOWN])
    if value is None:
        return Parameter(0, None, "nothing")
    return Parameter(0, list(value) if isinstance(value, Iterable) else None, "a list")

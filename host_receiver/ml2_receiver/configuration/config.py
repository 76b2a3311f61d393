"""Reads config.yaml: which streams shall run, and how."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from ..errors import CalibrationError, ConfigError, Problem
from ..table.reader import load_table
from ..table.stream_table import Stream
from ..wire.messages import Link
from .app_rules import USES, AppRules, NameRules
from .calibration import Calibration, load_calibration
from .config_rules import (
    Values,
    camera_problems,
    key_problems,
    marker_problems,
    read_values,
    without_modes,
)
from .parameter_file import (
    MAX_BYTES,
    Parameter,
    expected_one_of,
    is_of_ros,
    node_names,
    read_parameters,
    receivers_in,
)
from .whole_file import read_file

# Stands for any receiver.
_ANY = "/**"


@dataclass(frozen=True)
class Config:
    """A valid configuration.

    Attributes:
        values: every key, by "section.key".
        name: empty, or tells this headset from others.
        folder: what the names of files are relative to.
        cameras: the user's calibrations by section.
        ignored: what the file has for others, and so is not in `values`.
    """

    values: Values
    name: str = ""
    folder: Path = Path()
    cameras: Mapping[str, Calibration] = field(default_factory=dict)
    ignored: tuple[Problem, ...] = ()

    @property
    def prefix(self) -> str:
        """The prefix of all relative topics, "/magic_leap2" or "/NAME/magic_leap2"."""
        prefix = str(self.values["general.topic_name"]).removeprefix("/")
        return f"/{self.name}/{prefix}" if self.name else f"/{prefix}"

    @property
    def frame_prefix(self) -> str:
        """The prefix of all frame ids."""
        return f"{self.name}/" if self.name else ""

    @cached_property
    def requests(self) -> Mapping[str, Values]:
        """The entries of CONFIGURE: each enabled stream, in the order of the table."""
        streams = load_table().streams.values()
        running = [stream for stream in streams if stream.when and _runs(stream, self.values)]
        if running:
            running += [stream for stream in streams if stream.when is None]
        return {stream.id: _request(stream, self.values) for stream in running}

    @property
    def link(self) -> Link | None:
        """The `link` of CONFIGURE; None means that images do not give way to the link."""
        match self.values["general.link"]:
            case "auto":
                return Link(adapts=True)
            case "fixed":
                return None
            case mbit_per_s:
                return Link(adapts=True, most_mbit_per_s=float(mbit_per_s))

    @cached_property
    def app(self) -> AppRules:
        """The names of ROS that an app on the headset may use.

        Services below `custom/` need no rule, as topics there: `custom.enabled` is enough.
        """
        uses = {use: str(self.values[f"app.{use}"]).split() for use in USES}
        if self.values["custom.enabled"]:
            uses["offer"].append(f"{self.prefix}/custom/**")
        return AppRules(**{use: NameRules(tuple(names)) for use, names in uses.items()})

    @property
    def is_lazy(self) -> bool:
        """True if streams rest that no output needs."""
        return bool(self.values["publish.lazy"])

    @property
    def calibrations(self) -> Mapping[str, Calibration]:
        """The user's calibrations by stream, of those that shall run."""
        streams = load_table().streams
        return {
            id: self.cameras[streams[id].section]
            for id in self.requests
            if streams[id].section in self.cameras
        }

    def calibration_file(self, section: str) -> Path | None:
        """The file named for a camera's calibration, or None."""
        return _calibration_file(section, self.values, self.folder)


def load_config(path: Path, node: str | None = None) -> Config:
    """Reads a ROS 2 parameter file; keys that are not in it have the table's defaults.

    Args:
        node: the receiver's, with its namespace; None if the file may be for any receiver.

    Raises:
        ConfigError: with everything that is wrong in it, in the order of its lines.
    """
    try:
        return parse_config(read_file(path, MAX_BYTES), path.parent, node)
    except OSError as error:
        problem = Problem(0, "", "", f"cannot be read: {error.strerror}")
        raise ConfigError([problem], str(path)) from error
    except ConfigError as error:
        raise ConfigError(error.problems, str(path)) from error


def load_each(path: Path) -> dict[str, Config]:
    """Reads a ROS 2 parameter file for each receiver that it names, by the name of the node.

    Where it names at most one, it is read for any receiver.

    Raises:
        ConfigError: as load_config(); for several receivers with what is wrong for any of them.
    """
    config: dict[str, Config] = {}
    problems: dict[Problem, None] = {}
    nodes = _receivers_in(path)
    for node in nodes if len(nodes) > 1 else [None]:
        name = (node or "").rpartition("/")[0].strip("/")
        try:
            config[node or _ANY] = replace(load_config(path, node), name=name)
        except ConfigError as error:
            problems |= dict.fromkeys(error.problems)
    if problems:
        raise ConfigError(sorted(problems, key=lambda problem: problem.line), str(path))
    return config


def _receivers_in(path: Path) -> list[str]:
    try:
        return receivers_in(node_names(read_file(path, MAX_BYTES)))
    except (ConfigError, OSError):  # which load_config() says
        return []


def parse_config(data: bytes, folder: Path = Path(), node: str | None = None) -> Config:
    """Parses the bytes of a file as load_config does; paths in it are relative to `folder`."""
    table = load_table()
    parameters, problems, notes = read_parameters(data, node)
    others = {name: it for name, it in parameters.items() if _is_of_others(name, it)}
    parameters = {name: it for name, it in parameters.items() if name not in others}
    parameters, mistaken = without_modes(parameters, table.sections)
    problems += [*mistaken, *key_problems(parameters, table.sections)]
    values = read_values(parameters, table.sections)
    for section in table.sections.values():
        problems += camera_problems(section, parameters, values)
    problems += marker_problems(parameters, values)
    cameras, mistakes = read_calibrations(values, folder, table.sections)
    for section_id, mistake in mistakes.items():
        parameter = parameters[f"{section_id}.calibration"]
        problems.append(replace(mistake, line=parameter.line, value=parameter.text))
    if problems:
        raise ConfigError(sorted(problems, key=lambda problem: problem.line))
    return Config(values, folder=folder, cameras=cameras, ignored=(*notes, *_ignored(others)))


def _is_of_others(name: str, parameter: Parameter) -> bool:
    section = name.partition(".")[0]
    return is_of_ros(name) or (parameter.is_for_all and section not in load_table().sections)


def _ignored(others: Mapping[str, Parameter]) -> Iterator[Problem]:
    """Says once for each section why it is left out."""
    first: dict[str, Parameter] = {}
    for name, parameter in others.items():
        first.setdefault(name.partition(".")[0], parameter)
    for section, parameter in first.items():
        if is_of_ros(section):
            message = "ignored, since it is a parameter of ROS: give it by --params-file"
        else:
            expected = expected_one_of(load_table().sections, section)
            message = f"ignored, since it is no section of this node; {expected}"
        yield Problem(parameter.line, section, parameter.text, message)


def read_calibrations(
    values: Values, folder: Path, sections: Collection[str]
) -> tuple[dict[str, Calibration], dict[str, Problem]]:
    """The user's calibrations of some cameras, and what is wrong with others, by section."""
    calibrations: dict[str, Calibration] = {}
    problems: dict[str, Problem] = {}
    for section in sections:
        try:
            path = _calibration_file(section, values, folder)
            if path is not None:
                calibrations[section] = _calibration(section, path, values)
        except CalibrationError as error:
            name = f"{section}.calibration"
            problems[section] = Problem(0, name, str(values[name]), str(error))
    return calibrations, problems


def _calibration(section: str, path: Path, values: Values) -> Calibration:
    calibration = load_calibration(path)
    try:
        check_size(calibration, section, values)
    except CalibrationError as error:
        raise CalibrationError(f"{path}: {error}") from error
    return calibration


def check_size(calibration: Calibration, section: str, values: Values) -> None:
    """Checks that a calibration has the requested size of the camera's images.

    Raises:
        CalibrationError: it is not.
    """
    expected = tuple(values.get(f"{section}.resolution_{it}") for it in ("width", "height"))
    if (calibration.width, calibration.height) != expected:
        found = f"{calibration.width}x{calibration.height}"
        wanted = "x".join(map(str, expected))
        raise CalibrationError(f"expected a calibration for {wanted}, found {found}")


def _calibration_file(section: str, values: Values, folder: Path) -> Path | None:
    name = str(values.get(f"{section}.calibration") or "")
    try:
        return folder / Path(name).expanduser() if name else None
    except RuntimeError as error:
        raise CalibrationError(f"{name}: no such user has a home folder here") from error


def _runs(stream: Stream, values: Values) -> bool:
    when = stream.when or {}
    return all(values[f"{stream.section}.{key}"] in legal for key, legal in when.items())


def _request(stream: Stream, values: Values) -> Values:
    return {name.rpartition(".")[2]: values[name] for name in stream.values}

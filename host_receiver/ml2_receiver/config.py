"""Reads config.yaml: which streams shall run, and how."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .calibration import Calibration, load_calibration
from .config_rules import Parameters, Values, camera_problems, key_problems, read_values
from .errors import CalibrationError, ConfigError, Problem
from .parameter_file import MAX_BYTES, read_parameters
from .table import Section, Stream, load_table


@dataclass(frozen=True)
class Config:
    """A valid configuration.

    `prefix` is where all relative topics live, "/magic_leap2". `requests` has, for each stream
    that shall run and in the order of the table, the values CONFIGURE carries. `calibrations` has,
    by stream, the user's own for some of those that run.
    """

    prefix: str
    requests: Mapping[str, Values]
    calibrations: Mapping[str, Calibration] = field(default_factory=dict)


def load_config(path: Path) -> Config:
    """Reads a ROS 2 parameter file; keys that are not in it have the table's defaults.

    Raises:
        ConfigError: with everything that is wrong in it, in the order of its lines.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
        return parse_config(data, path.parent)
    except OSError as error:
        problem = Problem(0, "", "", f"cannot be read: {error.strerror}")
        raise ConfigError([problem], str(path)) from error
    except ConfigError as error:
        raise ConfigError(error.problems, str(path)) from error


def parse_config(data: bytes, folder: Path = Path()) -> Config:
    """As load_config, from the bytes of the file; `folder` is where files it names are."""
    table = load_table()
    parameters, problems = read_parameters(data)
    problems += key_problems(parameters, table.sections)
    values = read_values(parameters, table.sections)
    calibrations = {}
    for section in table.sections.values():
        problems += camera_problems(section, parameters, values)
        try:
            calibration = _calibration(section, values, folder)
        except CalibrationError as error:
            problems.append(_calibration_problem(section, parameters, error))
        else:
            if calibration is not None:
                calibrations[section.id] = calibration
    if problems:
        raise ConfigError(sorted(problems, key=lambda problem: problem.line))

    prefix = str(values["general.topic_name"])
    running = [stream for stream in table.streams.values() if stream.when and _runs(stream, values)]
    if running:
        running += [stream for stream in table.streams.values() if stream.when is None]
    return Config(
        prefix=prefix if prefix.startswith("/") else f"/{prefix}",
        requests={stream.id: _request(stream, values) for stream in running},
        calibrations={
            stream.id: calibrations[stream.section]
            for stream in running
            if stream.section in calibrations
        },
    )


def _calibration(section: Section, values: Values, folder: Path) -> Calibration | None:
    """The user's calibration of a camera, for the size its images are asked for in."""
    name = values.get(f"{section.id}.calibration")
    if not name:
        return None
    path = folder / Path(str(name)).expanduser()
    calibration = load_calibration(path)
    expected = tuple(values.get(f"{section.id}.resolution_{it}") for it in ("width", "height"))
    if (calibration.width, calibration.height) != expected:
        found = f"{calibration.width}x{calibration.height}"
        wanted = "x".join(map(str, expected))
        raise CalibrationError(f"{path}: expected a calibration for {wanted}, found {found}")
    return calibration


def _calibration_problem(section: Section, parameters: Parameters, error: Exception) -> Problem:
    name = f"{section.id}.calibration"
    return Problem(parameters[name].line, name, parameters[name].text, str(error))


def _runs(stream: Stream, values: Values) -> bool:
    when = stream.when or {}
    return all(values[f"{stream.section}.{key}"] == value for key, value in when.items())


def _request(stream: Stream, values: Values) -> Values:
    return {name.rpartition(".")[2]: values[name] for name in stream.values}

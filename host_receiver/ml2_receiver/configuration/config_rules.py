"""Checks configuration values, and describes the problems."""

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace

from ..errors import Problem
from ..table.key_values import accepts, expected, scalar
from ..table.reader import load_table
from ..table.stream_table import Mode, Section
from ..wire.json_body import Scalar
from .parameter_file import Parameter, expected_one_of

type Parameters = Mapping[str, Parameter]
type Values = Mapping[str, Scalar]

# Values that a mode allows for a camera's keys; each key narrows the choice for the next.
_STEPS: Mapping[tuple[str, ...], Callable[[Mode], Sequence[tuple[Scalar, ...]]]] = {
    ("stream",): lambda mode: [(mode.stream,)],
    ("resolution_width", "resolution_height"): lambda mode: mode.resolutions,
    ("update_rate",): lambda mode: [(rate,) for rate in mode.rates],
    ("format",): lambda mode: [(format,) for format in mode.formats],
}


_MODE = re.compile(r"(\d{1,6})x(\d{1,6})@(\d{1,6})", re.ASCII)
# The keys that a camera's parameter `mode` stands for.
MODE_KEYS = ("resolution_width", "resolution_height", "update_rate")
_EXAMPLE = "1280x720@30"


def mode_of(camera: str, values: Values) -> str:
    """Returns a camera's WIDTHxHEIGHT@RATE, the parameter `<camera>.mode`."""
    width, height, rate = (values[f"{camera}.{key}"] for key in MODE_KEYS)
    return f"{width}x{height}@{rate}"


def without_modes(
    parameters: Parameters, sections: Mapping[str, Section]
) -> tuple[dict[str, Parameter], list[Problem]]:
    """Replaces each `<camera>.mode` by the three keys that it stands for.

    Returns:
        the parameters, and the problems: text that is no mode, and a mode that contradicts a key
        which is given, too.
    """
    taken, problems = dict(parameters), []
    for section in sections.values():
        name = f"{section.id}.mode"
        if not section.modes or name not in parameters:
            continue
        mode = taken.pop(name)
        found = _MODE.fullmatch(mode.value) if isinstance(mode.value, str) else None
        if found is None:
            message = f"expected WIDTHxHEIGHT@RATE such as {_EXAMPLE}, found {mode.text}"
            problems.append(Problem(mode.line, name, mode.text, message))
            continue
        for key, number in zip(MODE_KEYS, found.groups(), strict=True):
            same = f"{section.id}.{key}"
            beside = taken.setdefault(same, replace(mode, value=int(number), text=number))
            if beside.value != int(number):
                message = f"found {mode.text}, but {same} is {beside.text}: give one of them"
                problems.append(Problem(mode.line, name, mode.text, message))
    return taken, problems


def key_problems(parameters: Parameters, sections: Mapping[str, Section]) -> Iterator[Problem]:
    """Yields unknown sections, once each, unknown keys, and values that their key cannot have."""
    unknown_sections = set()
    for name, parameter in parameters.items():
        section, _, key = name.partition(".")
        if section not in sections:
            if section not in unknown_sections:
                message = f"unknown section; {_expected_section(sections, section)}"
                yield Problem(parameter.line, section, parameter.text, message)
            unknown_sections.add(section)
        elif not key:
            message = f"expected keys under it, found {parameter.text}"
            yield Problem(parameter.line, name, parameter.text, message)
        elif key not in sections[section].keys:
            known = expected_one_of(sections[section].keys, key)
            message = f"unknown key with value {parameter.text}; {known}"
            yield Problem(parameter.line, name, parameter.text, message)
        elif not accepts(parameter.value, sections[section].keys[key]):
            message = f"expected {expected(sections[section].keys[key])}, found {parameter.text}"
            yield Problem(parameter.line, name, parameter.text, message)


def _expected_section(sections: Collection[str], found: str) -> str:
    stream = load_table().streams.get(found)
    if stream is not None:
        return f"the stream {found} is configured by the section {stream.section}"
    return expected_one_of(sections, found)


def read_values(parameters: Parameters, sections: Mapping[str, Section]) -> dict[str, Scalar]:
    """Returns all values by "section.key", defaults included, but none that its key cannot have.

    A number of a key of type "link" is a number, even if it is given as text; names are one text.
    """
    values: dict[str, Scalar] = {}
    for section in sections.values():
        for key in section.keys.values():
            name = f"{section.id}.{key.name}"
            value: object = parameters[name].value if name in parameters else key.default
            if accepts(value, key):
                values[name] = scalar(value, key)
    return values


def camera_problems(section: Section, parameters: Parameters, values: Values) -> Iterator[Problem]:
    """Yields values of a camera that are not legal together with those before them."""
    modes = section.modes
    context: list[str] = []
    seen: list[str] = []
    for keys, choices in _STEPS.items() if modes else ():
        names = [f"{section.id}.{key}" for key in keys]
        seen = names + seen
        if any(name not in values for name in names):
            continue
        value = tuple(values[name] for name in names)
        fitting = tuple(mode for mode in modes if value in choices(mode))
        if fitting:
            modes = fitting
            context.append(f"{keys[0]} {_text(value)}" if len(keys) == 1 else _text(value))
        else:
            allowed = dict.fromkeys(_text(choice) for mode in modes for choice in choices(mode))
            message = f"expected {' x '.join(keys)} to be one of {', '.join(allowed)}"
            message += f" with {', '.join(context)}" if context else ""
            yield _camera_problem(names, seen, parameters, value, message)


def _camera_problem(
    names: list[str],
    seen: list[str],
    parameters: Parameters,
    value: tuple[Scalar, ...],
    message: str,
) -> Problem:
    """Returns an error at the line of the value or, if that is a default, of a conflicting one."""
    given = [name for name in names if name in parameters]
    blamed = next(name for name in [*given, *seen] if name in parameters)
    found = "x".join(
        parameters[name].text if name in parameters else str(default)
        for name, default in zip(names, value, strict=True)
    )
    found += "" if given else " (the default)"
    return Problem(parameters[blamed].line, (given or names)[0], found, f"{message}, found {found}")


def _text(choice: tuple[Scalar, ...]) -> str:
    return "x".join(map(str, choice))


def marker_problems(parameters: Parameters, values: Values) -> Iterator[Problem]:
    """Yields a dictionary of another kind of markers, and the camera that excludes markers."""
    keys = ("enabled", "stream", "camera_id", "backend")
    camera = [values.get(f"picture_center.{it}") for it in keys]
    if values.get("markers.enabled") and camera == [True, 0, 1, "camera2"]:
        parameter = parameters["markers.enabled"]
        message = (
            "the headset tracks no markers while camera 1 of picture_center is open: "
            "give picture_center.camera_id 0, or only one of both sections"
        )
        yield Problem(parameter.line, "markers.enabled", parameter.text, message)
    kind, dictionary = values.get("markers.type"), values.get("markers.dictionary")
    known = load_table().sections["markers"].keys["dictionary"].allowed
    fitting = [it for it in known if ("X" in str(it)) == (kind == "aruco")]
    if kind != "qr" and dictionary in known and dictionary not in fitting:
        name = "markers.dictionary"
        blamed = parameters[name if name in parameters else "markers.type"]
        found = f"{dictionary}{'' if name in parameters else ' (the default)'}"
        allowed = ", ".join(map(str, fitting))
        message = f"expected one of {allowed} with type {kind}, found {found}"
        yield Problem(blamed.line, name, found, message)

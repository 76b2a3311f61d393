"""The configuration as parameters of the node."""

import math
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from ..configuration.calibration import Calibration
from ..configuration.config import Config
from ..configuration.parameter_file import expected_one_of
from ..configuration.settings import Settings, cameras, mode_name
from ..errors import ConfigError
from ..table.key_values import expected
from ..table.reader import load_table
from ..table.stream_table import CAMERA_KEYS, Key, Section
from ..wire.json_body import Scalar
from .failures import Failures, ServiceCallback
from .qos_overrides import check
from .status_array import DIAGNOSTICS

# Declared by rclpy, by it or for publishers, or for services; no keys of the configuration.
_OTHERS = re.compile(r"use_sim_time|start_type_description_service|(qos_overrides|record|save)\..*")
_TYPES = {
    "bool": Parameter.Type.BOOL,
    "integer": Parameter.Type.INTEGER,
    "number": Parameter.Type.DOUBLE,
}


class ParameterNode(Node):
    """A node whose parameters are the keys of the configuration, and `<camera>.mode`.

    Parameters given to ROS at its start go before those of `config`. Used by the node's executor.
    `failures` has what of it raised unexpectedly.

    Raises:
        ConfigError: parameters given at the start are wrong.
    """

    def __init__(self, name: str, context: Context, config: Config) -> None:
        self.failures = Failures(lambda text: self.get_logger().error(text))
        super().__init__(
            name, context=context, automatically_declare_parameters_from_overrides=True
        )
        self._overrides, of_qos = self._take_overrides()
        self._settings = self._settings_of(config)
        unused = check(of_qos, self._topics(), f"{self.config.prefix}/custom/")
        self._changed: Callable[[Settings], None] = lambda _: None
        types = {f"{s.id}.{key.name}": key.type for s in _sections() for key in s.keys.values()}
        self._types = {
            name: _TYPES.get(type, Parameter.Type.STRING) for name, type in types.items()
        }
        values = self._settings.parameters()
        for name, descriptor in _descriptors():
            descriptor.type = self._types.get(name, Parameter.Type.STRING).value
            value = self._parameter(name, values[name]).value
            self.declare_parameter(name, value, descriptor, ignore_override=True)
        for text in unused:
            self.get_logger().warning(text)

    @property
    def config(self) -> Config:
        """The configuration in force."""
        return self._settings.config

    def create_service(
        self, srv_type: Any, srv_name: str, callback: ServiceCallback, **of_ros: Any
    ) -> Any:
        """Works as in rclpy, but if the callback raises, the service answers that it failed."""
        answer = self.failures.answering(callback)
        return super().create_service(srv_type, srv_name, answer, **of_ros)

    def on_change(self, changed: Callable[[Settings], None]) -> None:
        """Calls `changed` after every change."""
        self._changed = changed

    def set_parameters_atomically(self, parameter_list: Sequence[Parameter]) -> SetParametersResult:
        """Sets parameters; ROS's parameter services call it with one parameter or with several.

        A single value of a camera that is not legal with the others waits for them, and the
        result's reason says so; several are legal together, or refused.
        """
        others = [parameter for parameter in parameter_list if _OTHERS.fullmatch(parameter.name)]
        changes = {p.name: p.value for p in parameter_list if p not in others}
        try:
            settings = self._settings.changed(
                changes, may_wait=len(parameter_list) == 1, by_peer=True
            )
        except ConfigError as error:
            return SetParametersResult(successful=False, reason=str(error))
        if not changes:
            return super().set_parameters_atomically(others)
        return self._take(settings, others)

    def calibrate(self, camera: str, calibration: Calibration) -> None:
        """Has this in force for a camera's section, until its parameter `calibration` is set."""
        self._settings = self._settings.calibrated(camera, calibration)
        self._changed(self._settings)

    def load(self, config: Config) -> SetParametersResult:
        """Sets all parameters as they would be had the node started with `config`."""
        return self._take(self._settings_of(config), [])

    def _take(self, settings: Settings, others: Sequence[Parameter]) -> SetParametersResult:
        """Sets the parameters that have other values in `settings`, and all of `others`."""
        before, after = self._settings.parameters(), settings.parameters()
        changed = [
            self._parameter(name, value) for name, value in after.items() if value != before[name]
        ]
        result = super().set_parameters_atomically([*changed, *others])
        if result.successful:
            self._settings = settings
            result.reason = "; ".join(f"{p.located_in('')}: waiting" for p in settings.pending)
            self._changed(settings)
        return result

    def _topics(self) -> dict[str, str]:
        """All topics that this node may publish, with their names after remappings."""
        table, prefix = load_table(), self.config.prefix
        names = [it.full_name(prefix) for stream in table.streams.values() for it in stream.topics]
        names += [f"{prefix}/{it.name}" for it in table.receiver_topics]
        return {it: self.resolve_topic_name(it) for it in (*names, DIAGNOSTICS)}

    def _settings_of(self, config: Config) -> Settings:
        try:
            return Settings.of(config).changed(self._overrides)
        except ConfigError as error:
            raise ConfigError(error.problems, "ROS parameters") from error

    def _take_overrides(self) -> tuple[dict[str, object], dict[str, object]]:
        """Undeclares the parameters given at the start, to declare them with types.

        Returns:
            those of this node, and those for the QoS of publishers. A file of ROS for several nodes
            may have sections of others, of which the log tells.
        """
        given = {
            name: self.get_parameter(name).value
            for name in self.get_parameters_by_prefix("")
            if name not in ("use_sim_time", "start_type_description_service")
        }
        for name in given:
            self.undeclare_parameter(name)
        own, of_others, sections = {}, set(), load_table().sections
        for name, value in given.items():
            section = name.partition(".")[0]
            if section in sections:
                own[name] = value
            elif not _OTHERS.fullmatch(name):
                of_others.add(section)
        for section in sorted(of_others):
            message = f"parameter {section}: no section of this node, and ignored"
            self.get_logger().warning(f"{message}; {expected_one_of(sections, section)}")
        return own, {it: given[it] for it in given if it.startswith("qos_overrides.")}

    def _parameter(self, name: str, value: Scalar) -> Parameter:
        type = self._types.get(name, Parameter.Type.STRING)
        match type:
            case Parameter.Type.DOUBLE:
                value = float(value)
            case Parameter.Type.STRING:  # which a number of the key `link` is as a parameter
                value = str(value)
        return Parameter(name, type, value)


def _sections() -> Sequence[Section]:
    return list(load_table().sections.values())


def _descriptors() -> Iterator[tuple[str, ParameterDescriptor]]:
    for section in _sections():
        for key in section.keys.values():
            yield f"{section.id}.{key.name}", _descriptor(section, key)
    for camera in cameras():
        modes = (
            f"stream {mode.stream}: {', '.join(f'{w}x{h}' for w, h in mode.resolutions)}"
            f" at {', '.join(map(str, mode.rates))} Hz"
            for mode in camera.modes
        )
        yield (
            mode_name(camera),
            ParameterDescriptor(
                description=f"{camera.doc} Resolution and rate in one, WIDTHxHEIGHT@RATE.",
                additional_constraints="; ".join(modes),
            ),
        )


def _descriptor(section: Section, key: Key) -> ParameterDescriptor:
    constraints = expected(key)
    if section.modes and key.name in CAMERA_KEYS:
        constraints += f"; only together as {mode_name(section)} lists them"
    descriptor = ParameterDescriptor(
        description=" ".join(filter(None, (section.doc, key.doc))),
        additional_constraints=constraints,
        read_only=key.read_only,
    )
    if key.type == "integer":
        descriptor.integer_range = [_range([int(value) for value in key.allowed or _between(key)])]
    elif key.minimum is not None:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(key.minimum), to_value=sys.float_info.max)
        ]
    return descriptor


def _between(key: Key) -> Sequence[int]:
    assert key.minimum is not None
    assert key.maximum is not None
    return range(int(key.minimum), int(key.maximum) + 1)


def _range(allowed: Sequence[int]) -> IntegerRange:
    least = min(allowed)
    step = math.gcd(*(value - least for value in allowed))
    return IntegerRange(from_value=least, to_value=max(allowed), step=step)

"""Reads ROS 2 parameter files and remembers on which line each value stands."""

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches

import yaml
from yaml.constructor import SafeConstructor
from yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from yaml.reader import ReaderError

from ..errors import ConfigError, Problem
from ..printable import printable
from .app_rules import matches
from .yaml_tree import TreeLoader

MAX_BYTES = 64 * 1024

# The node of this receiver, and the configuration node of the thesis that it replaces.
_NODE_NAMES = ("ml2_receiver", "config_ML_node")
# Names that stand for every node, alone or after namespaces.
_ANY_NODE = ("**", "*")
# Parameters that are no keys of the configuration: rclpy's own, those of the QoS of publishers, and
# those of the node's services. `ros2 param dump` writes them, too.
_OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides", "record", "save")
MAX_SHOWN = 60
_CHOOSE = "; `run --name` chooses one"


@dataclass(frozen=True)
class Parameter:
    """One value of the file.

    Attributes:
        text: what to show of it.
        is_for_all: it stands under a wildcard, so it may be meant for another node.
    """

    line: int
    value: object
    text: str
    is_for_all: bool = False


class _Loader(TreeLoader):
    """YAML 1.1 with the differences ROS's own parser has: no aliases, and 1e-3 is a number."""


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+$"), list("-+0123456789")
)


def expected_one_of(names: Collection[str], found: str) -> str:
    """ "expected one of ..." for an unknown name, with the likeliest one picked out."""
    close = get_close_matches(found, names, 1)
    return f"expected one of {', '.join(names)}" + (f"; did you mean {close[0]}?" if close else "")


def read_parameters(
    data: bytes, node: str | None = None
) -> tuple[dict[str, Parameter], list[Problem], list[Problem]]:
    """Returns the parameters by "section.key", the problems of the file's structure, and notes.

    Parameters of other nodes are left out, and of two values the last one holds, as in ROS. A
    section that has a value instead of keys is in the result by its own name.

    Args:
        node: as for chosen().

    Raises:
        ConfigError: the file is no YAML mapping at all.
    """
    blocks = list(_blocks(_compose(_decode(data)), ""))
    taken = chosen([it.node for it in blocks], node)
    own = {it.node: it for it in blocks if it.node in taken and not is_pattern(it.node)}
    problems = [
        it.wrong(f"expected one receiver, found {it.node} and {next(iter(own))}{_CHOOSE}")
        for it in list(own.values())[1:]
    ]
    parameters: dict[str, Parameter] = {}
    if not taken:
        known = [*_NODE_NAMES, "**"] if node is None else [node, "/**"]
        problems += [it.wrong(f"unknown node; {expected_one_of(known, it.node)}") for it in blocks]
    notes = [
        it.wrong(f"ignored, since this node is {node}{_CHOOSE}")
        for it in blocks
        if taken and not own and is_receiver(it.node) and it.node not in taken
    ]
    for block in blocks:
        if block.node not in taken:
            continue
        given: dict[str, Parameter] = {}
        for found in block.entries():
            if isinstance(found, Problem):
                problems.append(found)
                continue
            name, parameter = found
            first = given.setdefault(name, parameter)
            if first is not parameter:
                message = f"found {parameter.text}, but it is already given on line {first.line}"
                problems.append(Problem(parameter.line, name, parameter.text, message))
        parameters |= given
    return parameters, problems, notes


def chosen(paths: Sequence[str], node: str | None) -> list[str]:
    """Returns those of the nodes in a file whose parameters are this receiver's, in their order.

    They are those that ROS would take. A file that is only for a receiver with another name is for
    this one, too.

    Args:
        paths: names with their namespaces, which may have wildcards.
        node: the receiver's own; None stands for any receiver.
    """
    if node is None:
        return [it for it in paths if is_receiver(it) or is_wildcard(it)]
    name = node.rpartition("/")[2]
    found = [it for it in paths if matches(_with_name(it, name), node)]
    return found or receivers_in(paths)


def _with_name(path: str, name: str) -> str:
    """The path as if the receiver's node, which may be renamed, had this name."""
    return f"{path.rpartition('/')[0]}/{name}" if is_receiver(path) else path


def receivers_in(paths: Sequence[str]) -> list[str]:
    """Returns the nodes of receivers that a file names, in their order."""
    return list(dict.fromkeys(it for it in paths if is_receiver(it) and not is_pattern(it)))


def is_receiver(path: str) -> bool:
    """Returns True for the name of a receiver's node, whatever its namespaces."""
    return path.rpartition("/")[2] in _NODE_NAMES


def is_pattern(path: str) -> bool:
    """Returns True if this path may stand for several nodes."""
    return "*" in path


def is_wildcard(path: str) -> bool:
    """Returns True if parameters under this path are for all nodes."""
    return path.rpartition("/")[2] in _ANY_NODE


def is_of_ros(name: str) -> bool:
    """Returns True for a parameter that is no key of the configuration, but ROS's own."""
    return name.partition(".")[0] in _OF_ROS


def node_names(data: bytes) -> list[str]:
    """Returns the names of all nodes in the file, with their namespaces.

    Raises:
        ConfigError: the file is no YAML mapping at all.
    """
    return [block.node for block in _blocks(_compose(_decode(data)), "")]


def _decode(data: bytes) -> str:
    if len(data) > MAX_BYTES:
        raise ConfigError([Problem(0, "", "", f"expected at most {MAX_BYTES} bytes")])
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        found = f"0x{data[error.start]:02x}"
        message = f"expected UTF-8, found the byte {found}"
        raise ConfigError([Problem(line, "", found, message)]) from error


def _compose(text: str) -> MappingNode:
    try:
        root = yaml.compose(text, _Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        reason = ", ".join(filter(None, (error.context, error.problem)))
        raise _invalid(mark.line + 1 if mark else 0, reason) from error
    except ReaderError as error:
        raise _invalid(text.count("\n", 0, error.position) + 1, error.reason) from error
    except RecursionError as error:
        raise _invalid(0, "nested too deeply") from error
    except (ValueError, OverflowError) as error:  # from escapes such as "\UFFFFFFFF"
        raise _invalid(0, error) from error
    if not isinstance(root, MappingNode) or not root.value:
        found = "an empty file" if root is None else _text(root)
        message = f"expected /{_NODE_NAMES[0]}: with ros__parameters: under it, found {found}"
        raise ConfigError([Problem(1, "", found, message)])
    return root


def _invalid(line: int, reason: object) -> ConfigError:
    return ConfigError([Problem(line, "", "", f"not valid YAML: {reason}")])


@dataclass(frozen=True)
class _Block:
    """The parameters of one node; `node` is its name with its namespaces."""

    node: str
    key: Node
    body: Node

    def wrong(self, message: str) -> Problem:
        return _wrong(self.key, self.body, message)

    def entries(self) -> Iterator[Problem | tuple[str, Parameter]]:
        if not isinstance(self.body, MappingNode) or not self.body.value:
            yield self.wrong(f"expected ros__parameters: under it, found {_text(self.body)}")
            return
        for name, sections in self.body.value:
            if _name(name) != "ros__parameters":
                yield _wrong(name, sections, "expected ros__parameters")
            elif not isinstance(sections, MappingNode):
                yield _wrong(name, sections, f"expected sections under it, found {_text(sections)}")
            else:
                for of_section, parameter in _sections(sections):
                    yield of_section, replace(parameter, is_for_all=is_wildcard(self.node))


def _blocks(root: MappingNode, namespace: str) -> Iterator[_Block]:
    """Yields the nodes. A name without ros__parameters is a namespace, as in ROS."""
    for key, body in root.value:
        node = f"{namespace}/{_name(key).removeprefix('/')}"
        is_namespace = (
            not (is_receiver(node) or is_wildcard(node))
            and isinstance(body, MappingNode)
            and all(isinstance(it, MappingNode) for _, it in body.value)
            and not any(_name(it) == "ros__parameters" for it, _ in body.value)
        )
        if is_namespace and body.value:
            yield from _blocks(body, node)
        else:
            yield _Block(node, key, body)


def _sections(sections: MappingNode) -> Iterator[tuple[str, Parameter]]:
    for section, keys in sections.value:
        if isinstance(keys, MappingNode):
            for key, value in keys.value:
                yield f"{_name(section)}.{_name(key)}", _parameter(key, value)
        else:  # ROS's flat spelling, general.topic_name: ...
            yield _name(section), _parameter(section, keys)


def _wrong(key: Node, value: Node, message: str) -> Problem:
    return Problem(key.start_mark.line + 1, _name(key), _text(value), message)


def _parameter(key: Node, value: Node) -> Parameter:
    return Parameter(key.start_mark.line + 1, _value(value), _text(value))


def _value(node: Node) -> object:
    """Returns the value of a scalar, or those of a list; None if no key can have it."""
    if isinstance(node, SequenceNode):
        return [_value(it) if isinstance(it, ScalarNode) else None for it in node.value]
    if not isinstance(node, ScalarNode):
        return None
    try:
        return SafeConstructor().construct_object(node)
    except (yaml.YAMLError, ValueError, KeyError, IndexError):  # such as !!bool maybe
        return None


def _name(key: Node) -> str:
    return printable(key.value) if isinstance(key, ScalarNode) else _text(key)


def _text(node: Node) -> str:
    if not isinstance(node, ScalarNode):
        kind = "mapping" if isinstance(node, MappingNode) else "list"
        return f"a {kind}" if node.value else f"an empty {kind}"
    text = printable(node.value)
    if len(text) > MAX_SHOWN:
        text = text[:MAX_SHOWN] + "..."
    return f'"{text}"' if node.style else text or "nothing"

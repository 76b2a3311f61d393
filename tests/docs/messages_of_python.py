"""The receiver's messages: of its typed errors, wrong options, warnings, diagnostics and doctor."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

from document import ROOT
from message import HOLE, Message
from ml2_receiver import errors

PACKAGE = ROOT / "host_receiver" / "ml2_receiver"
# By which argument of a call is the message. What a peer did wrong is told by its code.
_TELLING = {
    **{name: 0 for name, it in vars(errors).items() if str(it).endswith("Error'>")},
    **{"ProtocolError": -1, "ConfigError": -1, "Problem": 3},
    **{"ArgumentTypeError": 0, "Finding": 0, "_camera_problem": 4, "StreamAnswer": 2},
}
_NOT_WELL = {"Level.WARN", "Level.ERROR", "level"}


def messages_of_python() -> Iterator[Message]:
    for file in sorted(PACKAGE.rglob("*.py")):
        source = _Source(ast.parse(file.read_text()))
        for node in ast.walk(source.module):
            for text in source.told_by(node):
                yield Message.at(file, getattr(node, "lineno", 1), text)


@dataclass
class _Source:
    module: ast.Module

    def __post_init__(self) -> None:
        walked = ast.walk(self.module)
        functions = [it for it in walked if isinstance(it, ast.FunctionDef)]
        self._function = {id(node): it for it in functions for node in ast.walk(it)}

    def told_by(self, node: ast.AST) -> Iterator[str]:
        parts = node.args if isinstance(node, ast.Call) else getattr(node, "elts", [])
        if any(
            isinstance(it, ast.Name | ast.Attribute) and ast.unparse(it) in _NOT_WELL
            for it in parts
        ):
            yield from (text for it in parts for text in self._texts(it) if " " in text)
        if not isinstance(node, ast.Call):
            return
        name = getattr(node.func, "id", getattr(node.func, "attr", ""))
        if ast.unparse(node.func).endswith("losses.add"):
            yield from self._texts(parts[0])
        if (index := _TELLING.get(name, -1)) in range(len(parts)):
            yield from self._texts(parts[index])
        if name == "print":
            told = (text for it in parts for text in self._texts(it))
            yield from (text for text in told if text.startswith(("WARNING", "ERROR")))

    def _texts(self, node: ast.expr) -> Iterator[str]:
        """What an expression may be, a name by all that its function or the module gives it."""
        match node:
            case ast.Constant(value=str(text)):
                yield text
            case ast.JoinedStr(values=parts):
                filled = (it.value if isinstance(it, ast.Constant) else HOLE for it in parts)
                yield "".join(map(str, filled))
            case ast.Call(func=ast.Attribute(value=template, attr="format")):
                yield from (it.replace("{}", HOLE) for it in self._texts(template))
            case _:
                yield from (text for it in self._choices(node) for text in self._texts(it))

    def _choices(self, node: ast.expr) -> list[ast.expr]:
        match node:
            case ast.Name(id=name):
                return self._given(name, self._function.get(id(node), self.module))
            case ast.BoolOp(values=choices) | ast.Dict(values=choices):
                return choices
            case ast.IfExp(body=body, orelse=orelse):
                return [body, orelse]
            case ast.Call(func=ast.Attribute(value=table, attr="get"), args=[_, default]):
                return [table, default]
        return []

    def _given(self, name: str, scope: ast.AST) -> list[ast.expr]:
        given = [
            it.value
            for it in ast.walk(scope)
            if isinstance(it, ast.Assign)
            and any(isinstance(to, ast.Name) and to.id == name for to in it.targets)
        ]
        return given if given or scope is self.module else self._given(name, self.module)

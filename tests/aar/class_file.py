"""The declarations and references of a class file: as much of its format (JVM
specification, chapter 4) as that needs.
"""

import struct
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

_UTF8 = 1
_CLASS = 7
_MEMBERS = {9, 10, 11}  # field, method, method of an interface
_TWO_SLOTS = {5, 6}  # long, double
# Bytes after the tag of every constant but _UTF8.
_SIZES = {3: 4, 4: 4, 5: 8, 6: 8, 7: 2, 8: 2, 9: 4, 10: 4, 11: 4, 12: 4}
_SIZES |= {15: 3, 16: 2, 17: 4, 18: 4, 19: 2, 20: 2}


@dataclass(frozen=True, order=True)
class Member:
    """A field or method; names and descriptors as in class files: `java/lang/String`, `(I)V`."""

    owner: str
    name: str
    descriptor: str

    def __str__(self) -> str:
        return f"{self.owner}.{self.name} {self.descriptor}"


@dataclass(frozen=True)
class ClassFile:
    """`classes` and `members` are those it refers to; arrays stand for their elements."""

    name: str
    parents: tuple[str, ...]
    declared: frozenset[tuple[str, str]]
    classes: frozenset[str]
    members: frozenset[Member]


def read_classes(*jars: Path) -> dict[str, ClassFile]:
    """The classes of jars by name; the first of several wins, as on a class path."""
    classes: dict[str, ClassFile] = {}
    for jar in jars:
        with zipfile.ZipFile(jar) as archive:
            for entry in archive.namelist():
                if entry.endswith(".class") and not entry.startswith("META-INF/"):
                    parsed = _Parser(archive.read(entry)).parse()
                    classes.setdefault(parsed.name, parsed)
    return classes


class _Parser:
    def __init__(self, data: bytes) -> None:
        self._data = data
        self._position = 8  # magic and version
        self._constants: dict[int, tuple[int, bytes]] = {}

    def parse(self) -> ClassFile:
        self._read_constants()
        self._u2()  # access
        name = self._class_name(self._u2())
        parents = [self._u2(), *(self._u2() for _ in range(self._u2()))]
        declared = {*self._declarations(), *self._declarations()}
        constants = self._constants.items()
        return ClassFile(
            name,
            tuple(self._class_name(index) for index in parents if index),
            frozenset(declared),
            frozenset(self._class_name(index) for index, (tag, _) in constants if tag == _CLASS),
            frozenset(self._member(body) for _, (tag, body) in constants if tag in _MEMBERS),
        )

    def _read_constants(self) -> None:
        index, end = 1, self._u2()
        while index < end:
            tag = self._take(1)[0]
            self._constants[index] = tag, self._take(self._u2() if tag == _UTF8 else _SIZES[tag])
            index += 2 if tag in _TWO_SLOTS else 1

    def _declarations(self) -> Iterator[tuple[str, str]]:
        """The fields, and then the methods, with their attributes passed over."""
        for _ in range(self._u2()):
            _, name, descriptor, attributes = struct.unpack(">4H", self._take(8))
            for _ in range(attributes):
                self._take(2)
                self._take(int.from_bytes(self._take(4)))
            yield self._text(name), self._text(descriptor)

    def _member(self, body: bytes) -> Member:
        owner, signature = struct.unpack(">HH", body)
        name, descriptor = struct.unpack(">HH", self._constants[signature][1])
        return Member(self._class_name(owner), self._text(name), self._text(descriptor))

    def _class_name(self, index: int) -> str:
        name = self._text(int.from_bytes(self._constants[index][1]))
        return name.lstrip("[").removeprefix("L").removesuffix(";") if name[0] == "[" else name

    def _text(self, index: int) -> str:
        return self._constants[index][1].decode("utf-8", "surrogatepass")

    def _u2(self) -> int:
        return int.from_bytes(self._take(2))

    def _take(self, count: int) -> bytes:
        self._position += count
        return self._data[self._position - count : self._position]

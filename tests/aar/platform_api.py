"""The members of the Android platform that classes use, and whether a version has them."""

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from class_file import ClassFile, Member
from toolchain import jar, java

_HERE = Path(__file__).parent
_PRIMITIVES = frozenset("BCDFIJSZ")
Classes = Mapping[str, ClassFile]


@dataclass(frozen=True)
class Allowed:
    """A row of allowed_api.tsv: a class or member that is newer than `public_api`."""

    name: str
    level: int
    reason: str


def allowed_api() -> list[Allowed]:
    with (_HERE / "allowed_api.tsv").open(newline="") as file:
        rows = csv.DictReader(file, delimiter="\t")
        return [Allowed(row["name"], int(row["api_level"]), row["reason"]) for row in rows]


def public_api() -> dict[str, ClassFile]:
    """The public API of Android 7 (level 24), java.* included, by what its classes declare."""
    printer = _HERE / "PrintSignatures.java"
    printed = java([jar("animal-sniffer")], printer, jar("android-api-level-24"))
    return {file.name: file for file in map(_described, printed.splitlines())}


def missing_api(program: Classes, libraries: Classes, platform: Classes) -> set[str]:
    """The classes and members that `program` refers to and neither itself nor the others have."""
    world = {**platform, **libraries, **program}
    return set(_missing(program, world))


def has_api(platform: Classes, name: str) -> bool:
    """Returns True if a platform has a class or member, named as in `missing_api`."""
    owner, _, member = name.partition(".")
    return _declares(platform, Member(owner, *member.split(" "))) if member else name in platform


def _missing(program: Classes, world: Classes) -> Iterator[str]:
    for file in program.values():
        yield from file.classes - world.keys() - _PRIMITIVES
        yield from (str(member) for member in file.members if not _declares(world, member))


def _declares(world: Classes, member: Member) -> bool:
    """Returns True if the owner or an ancestor declares the member. Arrays have those of Object."""
    owners = [member.owner, "java/lang/Object"]
    for owner in owners:
        if owner in world:
            if (member.name, member.descriptor) in world[owner].declared:
                return True
            owners.extend(world[owner].parents)
    return False


def _described(line: str) -> ClassFile:
    name, parents, members = line.split("\t")
    declared = frozenset(re.findall(r"([^(# ]+)#?(\S+)", members))
    return ClassFile(name, tuple(parents.split()), declared, frozenset(), frozenset())

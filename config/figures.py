"""Prints figures of the repository: files, lines by area, words of documents, circular imports.

With --check it prints nothing but what is wrong, and fails on circular imports between packages of
Python and Kotlin and between modules of C and C++, on MOST_FILES files, and on comments that begin
with one of HANGING.
"""

import argparse
import ast
import re
import subprocess
import sys
from collections import Counter, defaultdict
from collections.abc import Iterable
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST_FILES = 1950
SOURCES = {".c", ".cpp", ".cs", ".h", ".java", ".kt", ".py", ".rs", ".sh"}
# Words that begin a clause without saying what the thing does or is.
HANGING = "Of|Those|What|Where|Whether|Which|Who|Whose|Why|How"
DOCUMENTATION = re.compile(rf'(?:^\s*"""|/\*\*<?|///<|<summary>)\s*({HANGING})\b')
COMMENT = re.compile(rf"\s*(?:#|//|\*)\s*({HANGING})\b")
INSIDE_COMMENT = re.compile(r"\s*(?:#|//|\*(?!/))\s*\S")
# The first that matches a path is its area; other sources are the product.
AREAS = {
    "tests": r"(^|/)(tests?|Tests|benchmark)/",
    "simulators": r"^native/sim/|/(simulator|android-test|demo)/",
    "build and generators": r"^(config|\.ci)/|/environment/",
}
KOTLIN = ROOT / "ml2-sensors-aar" / "src" / "main" / "kotlin" / "dev" / "ml2sensors"
PYTHON = ("ml2_receiver", "ml2_tools")
NATIVE = ROOT / "native"
# Folders of NATIVE whose headers are included by name from other folders.
HEADERS = ("sdk", "sim", "sim/scene")


def files() -> list[Path]:
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "--deduplicate"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout.splitlines()
    return [ROOT / name for name in listed if (ROOT / name).is_file()]


def area(path: Path) -> str:
    name = path.relative_to(ROOT).as_posix()
    return next((area for area, rule in AREAS.items() if re.search(rule, name)), "product")


def python_imports() -> Iterable[tuple[str, str]]:
    """Package and imported package, for each import in a package of PYTHON."""
    for distribution in PYTHON:
        for file in (ROOT / "host_receiver" / distribution).rglob("*.py"):
            module = file.relative_to(ROOT / "host_receiver").with_suffix("").parts
            for node in ast.walk(ast.parse(file.read_text())):
                for used in imported(node, module):
                    if used[0] in PYTHON and len(used) > 1 and len(module) > 2:
                        yield ".".join(module[:2]), ".".join(used[:2])


def imported(node: ast.AST, module: tuple[str, ...]) -> list[tuple[str, ...]]:
    """The modules that a statement of `module` imports, by their parts."""
    if isinstance(node, ast.ImportFrom):
        beginning = module[: -node.level] if node.level else ()
        package = (*beginning, *(node.module or "").split("."))
        return [(*filter(None, package), it.name) for it in node.names]
    if isinstance(node, ast.Import):
        return [tuple(it.name.split(".")) for it in node.names]
    return []


def kotlin_imports() -> Iterable[tuple[str, str]]:
    for file in KOTLIN.rglob("*.kt"):
        user = file.parent.relative_to(KOTLIN).as_posix()
        for used in re.findall(r"^import dev\.ml2sensors\.(\w+)\.", file.read_text(), re.MULTILINE):
            yield user, used


def c_includes() -> Iterable[tuple[str, str]]:
    """Module and included module, for each include in NATIVE; a .c or .cpp and its .h are one."""
    for file in NATIVE.rglob("*.*"):
        user = file.relative_to(NATIVE).with_suffix("").as_posix()
        if file.suffix in {".c", ".cpp", ".h"} and not user.startswith("tests/"):
            for name in re.findall(r'^#include "(.+)"', file.read_text(), re.MULTILINE):
                places = [folder / name for folder in (file.parent, *map(NATIVE.joinpath, HEADERS))]
                used = next(filter(Path.is_file, places), None)
                if used is None:
                    sys.exit(f"{file}: {name} is in none of the folders of HEADERS")
                used = used.resolve()
                yield user, used.relative_to(NATIVE).with_suffix("").as_posix()


def circle(imports: Iterable[tuple[str, str]]) -> str | None:
    """A circle of packages or modules that import each other, if there is one."""
    graph: dict[str, set[str]] = defaultdict(set)
    for user, used in imports:
        if user != used:
            graph[user].add(used)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return " <- ".join(error.args[1])
    return None


def hanging(path: Path) -> Iterable[str]:
    """Place and first word of each comment that begins with one of HANGING."""
    before = ""
    for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
        found = DOCUMENTATION.search(line)
        if not INSIDE_COMMENT.match(before):
            found = found or COMMENT.match(line)
        if found:
            yield f"{path.relative_to(ROOT)}:{number}: a comment begins with {found[1]!r}"
        before = line


def problems(paths: list[Path]) -> list[str]:
    circles = {
        "Python packages import": circle(python_imports()),
        "Kotlin packages import": circle(kotlin_imports()),
        "C modules include": circle(c_includes()),
    }
    found = [f"{users} each other: {it}" for users, it in circles.items() if it]
    if len(paths) >= MOST_FILES:
        found.append(f"the repository has {len(paths)} files; fewer than {MOST_FILES} are allowed")
    commented = (it for it in paths if it.suffix in SOURCES | {".js", ".yaml", ".yml"})
    hangs = [place for path in commented for place in hanging(path)]
    if hangs:
        hangs.append("expected in each comment above: first what the thing does or is")
    return found + hangs


def print_figures(paths: list[Path]) -> None:
    lines: Counter[str] = Counter()
    words: dict[str, int] = {}
    for path in paths:
        if path.suffix in SOURCES:
            lines[area(path)] += len(path.read_bytes().splitlines())
        elif path.suffix == ".md":
            words[path.relative_to(ROOT).as_posix()] = len(path.read_text().split())
    print(f"{len(paths):7} files")
    for name, count in lines.most_common():
        print(f"{count:7} lines of {name}")
    print(f"{sum(words.values()):7} words of documents")
    for name, count in sorted(words.items(), key=lambda it: -it[1]):
        print(f"{count:7} words in {name}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="print and fail for what is wrong")
    arguments = parser.parse_args()
    paths = files()
    if not arguments.check:
        print_figures(paths)
    found = problems(paths)
    print("\n".join(found), file=sys.stderr)
    return 1 if arguments.check and found else 0


if __name__ == "__main__":
    sys.exit(main())
